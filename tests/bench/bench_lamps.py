"""What an area lamp costs beside the sun, on pool.blend: pieces, CPU seconds of a frame, estimated and true error.

Run as `.venv/bin/python tests/bench/bench_lamps.py`; it prints the table of docs/lights.md. The truth is the sum of
36 pieces. Medians of frames that take turns.
"""

from __future__ import annotations

import os
import statistics
import time
from dataclasses import replace

import numpy as np
from bench_stages import Table, load_dapple, machine
from sample_scenes import read

TURNS, PLACES, RESOLUTION = 4, 36, 256  # the first turn does not count
LAMPS = ("sun", 0.0), ("0.2 m", 0.1), ("1 m", 0.5)
ABOVE = 2.0  # m over the water
HEAD = "side", "tolerance", "pieces", "seconds", "times a point lamp", "error", "its estimate"


def lamp(scene, half):
    """A square Area over the middle of the water."""
    from dapple.kernels.scene import Area

    low, high = scene.water.positions.min(0), scene.water.positions.max(0)
    place = np.append((low + high)[:2] / 2, high[2] + ABOVE)
    return Area("Panel", place, np.ones(3), half_axes=half * np.array([[1.0, 0, 0], [0, -1.0, 0]]))


def truth(scene, texels, light):
    """Images by many pieces of a lamp."""
    from dapple.kernels.area_lamps import pieces
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Settings

    side = round(PLACES**0.5)
    places = [replace(one, among=1) for one in pieces(light, (side, side))]
    settings = Settings("photon_splat", 1e-2, RESOLUTION)
    parts = (solve(replace(scene, lights=(one,)), texels, settings).images for one in places)
    return [sum(images) for images in zip(*parts, strict=True)]


def row(scene, texels, light, expected, tolerance):
    """Pieces, CPU seconds of a frame, how many times those of a point lamp, error and its estimate."""
    from dapple.kernels.area_lamps import cut
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Point, Settings

    settings, taken = Settings("photon_splat", tolerance, RESOLUTION), []
    scenes = [replace(scene, lights=(one,)) for one in (light, Point("Point", lamp(scene, 1.0).position, np.ones(3)))]
    for _ in range(TURNS):
        answers, seconds = zip(*(_timed(solve, one, texels, settings) for one in scenes), strict=True)
        taken.append((seconds[0], seconds[0] / seconds[1]))
    own, ratio = (statistics.median(column) for column in zip(*taken[1:], strict=True))
    error = "" if expected is None else f"{_off(answers[0].images, expected):.1e}"
    count = len(cut(scenes[0], texels, tolerance)[0].lights)
    return count, f"{own:.2f}", f"{ratio:.1f}", error, f"{answers[0].diagnostics.estimated_error:.1e}"


def _timed(solve, *given):
    start = time.process_time()
    answer = solve(*given)
    return answer, time.process_time() - start


def _off(images, expected):
    """Mean squared error over the mean square, over all receivers."""
    pairs = list(zip(images, expected, strict=True))
    return sum(((a - b) ** 2).sum() for a, b in pairs) / sum((b**2).sum() for _, b in pairs)


def main():
    load_dapple(register=False)
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.presets import PRESETS

    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    whole, table = read("pool"), Table()
    table.head(*HEAD)
    (bed,) = (receiver for receiver in whole.receivers if receiver.name == "Floor")
    scene = replace(whole, receivers=(bed,), occluders=(), casters=())
    texels = [rasterise(bed, RESOLUTION)]
    for name, half in LAMPS:
        light = lamp(scene, half) if half else scene.lights[0]
        expected = truth(scene, texels, light) if half else None
        for preset, tolerance in PRESETS.items():
            table.add(name, f"{preset.title()}, {tolerance:g}", *row(scene, texels, light, expected, tolerance))
    print(machine())


if __name__ == "__main__":
    main()
