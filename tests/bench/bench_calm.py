"""How much less a frame of an animation takes by auto than by the complete solver, where little is needed.

Run as `.venv/bin/python tests/bench/bench_calm.py`; it prints the table of docs/planner.md. CPU seconds, medians of
frames that take turns: two frames of calm_pond.blend, its waves on finer meshes, and a draft of the pool of the tests.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from dataclasses import replace

import numpy as np
from bench_stages import Table, load_dapple, machine

TURNS = 6  # of which the first does not count
HEAD = (
    "scene", "triangles", "texels", "asked", "choice", "auto [s]", "planning [s]", "complete [s]", "complete / auto",
    "alone [s]",
)  # fmt: skip
# of sample_blends/build_calm_pond.py: m; amplitude and wavelength [m], heading [degrees], phase
SIDE, LEVEL = 3.2, 0.6
WAVES = (0.0036, 1.40, 15.0, 0.3), (0.0022, 0.80, 70.0, 1.9), (0.0017, 0.50, -35.0, 2.6), (0.0011, 0.33, 110.0, 0.8)


def calm(scene, quads, phase):
    """The Scene of the calm pond with its waves on a grid of quads x quads, moved along by a phase."""
    from waves import grid, shaded_smooth

    x, y, triangles = grid(quads, SIDE)
    z = np.full_like(x, LEVEL)
    for height, length, heading, start in WAVES:
        along = np.cos(np.radians(heading)) * x + np.sin(np.radians(heading)) * y
        z += height * np.sin(2 * np.pi / length * along + start + phase)
    return replace(scene, water=shaded_smooth(np.stack([x, y, z], 1).astype(np.float32).astype(float), triangles))


def pool(phase):
    """The pool of the tests on 33 thousand triangles, its waves moved along."""
    from bench.accuracy_ponds import pool as still
    from bench.estimate_ponds import water_of

    pond = still()
    pond = replace(pond, waves=replace(pond.waves, phase=pond.waves.phase + phase))
    return pond.scene(water_of(pond, 128))


def row(name, frames, tolerance, resolution):
    """Cells of HEAD for two frames of one animation."""
    from dapple.kernels.anchor import Kept
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import prepare, solve
    from dapple.kernels.plan.planner import planned
    from dapple.kernels.scene import Settings

    own = tuple(rasterise(receiver, resolution) for receiver in frames[0].receivers)
    auto = Settings(tolerance=tolerance, resolution=resolution)
    anchor = prepare(frames[0], own, auto)
    kept, every, taken = Kept(anchor), Kept(anchor), []
    runs = (
        lambda scene: solve(scene, own, auto, kept),
        lambda scene: planned(scene, own, auto, anchor.smoothing, anchor.plan),
        lambda scene: solve(scene, own, replace(auto, method="photon_splat"), every),
        lambda scene: solve(scene, own, auto, Kept(anchor)),
    )
    for turn in range(TURNS):
        taken.append([_seconds(run, frames[turn % 2]) for run in runs])
    seconds = [statistics.median(column) for column in zip(*taken[1:], strict=True)]
    ratio = statistics.median(line[2] / line[0] for line in taken[1:])
    kind = anchor.plan.choice.kind
    cells = (f"{value:.4f}" for value in seconds[:3])
    of = name, len(frames[0].water.triangles), f"{resolution}²", f"{tolerance:g}", kind
    return *of, *cells, f"{ratio:.1f}", f"{seconds[3]:.3f}"


def _seconds(run, scene):
    start = time.process_time()
    run(scene)
    return time.process_time() - start


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple(register=False)
    from bench.sample_scenes import read

    pond, table = [read("calm_pond", frame) for frame in (2, 3)], Table()
    table.head(*HEAD)
    for resolution in (256, 512):
        table.add(*row("calm_pond.blend", pond, 1e-2, resolution))
    table.add(*row("calm_pond.blend", pond, 1e-3, 256))
    for quads in (256, 512):
        table.add(*row("the same waves", [calm(pond[0], quads, phase) for phase in (0.0, 0.4)], 1e-2, 512))
    plane = [replace(pool(0.0), water=scene.water) for scene in (calm(pond[0], 96, phase) for phase in (0.0, 0.4))]
    table.add(*row("the same over a plane", plane, 1e-2, 256))
    table.add(*row("pool of the tests", [pool(phase) for phase in (0.0, 0.2)], 5e-2, 256))
    print(machine())


if __name__ == "__main__":
    sys.exit(main())
