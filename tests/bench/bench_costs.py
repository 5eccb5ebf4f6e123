"""The constants of `kernels/plan/cost.py`: microseconds to begin with, for a triangle, for a texel.

Run as `.venv/bin/python tests/bench/bench_costs.py`; it pins itself to one core and prints them.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from functools import partial

import numpy as np
from bench_stages import load_dapple

QUADS, SIDES = (48, 96, 192), (96, 192, 384)
REPEATS = 6  # of which the first, cold, does not count


def measured(pond, *each):
    """(1, triangles, texels) (n,3) and CPU seconds (n,) of solves of a Pond by Settings in a frame of an animation, or,
    of two, by how much the second takes longer: they take turns."""
    from bench.estimate_ponds import water_of

    from dapple.kernels.anchor import Kept
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import prepare, solve

    counts, seconds = [], []
    for quads in QUADS:
        scene = pond.scene(water_of(pond, quads))
        for side in SIDES:
            own = [rasterise(scene.receivers[0], side)]
            runs = [partial(solve, scene, own, how, Kept(prepare(scene, own, how))) for how in each]
            counts.append((1, 2 * quads**2, side**2))
            seconds.append(_median(runs))
    return np.array(counts, float), np.array(seconds)


def _median(runs):
    """Median CPU seconds of one run, or of how much longer the second takes."""
    taken = []
    for _ in range(REPEATS):
        each = []
        for run in runs:
            start = time.process_time()
            run()
            each.append(time.process_time() - start)
        taken.append(each[-1] - (each[0] if len(each) > 1 else 0.0))
    return statistics.median(taken[1:])


def fitted(counts, seconds):
    """The constants (3,) [microseconds], none below 0, of the least relative error."""
    used, seconds = [0, 1, 2], np.maximum(seconds, 1e-4)
    while True:
        found, *_ = np.linalg.lstsq(counts[:, used] / seconds[:, None], np.ones(len(seconds)), rcond=None)
        if (found >= 0).all():
            break
        used.remove(used[int(np.argmin(found))])
    constants = np.zeros(3)
    constants[used] = 1e6 * found
    return constants


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    from dataclasses import replace

    from bench.accuracy_ponds import pool

    from dapple.kernels.scene import Settings

    plain = replace(pool(), waves=replace(pool().waves, amplitude=0.3 * pool().waves.amplitude))
    mesh, smooth = Settings("photon_splat", 1e-2, surface="mesh"), Settings("photon_splat", 3e-3)
    bare = replace(mesh, without=("disc",))
    cases = {
        "FLAT": (plain, Settings("flat")),
        "BEAMS": (plain, mesh),
        "BEAMS_BY_RAYS": (plain.with_relief(), mesh),
        "SURFACE": (plain, mesh, smooth),
        "DISC": (plain.with_disc(), bare, mesh),
    }
    for name, case in cases.items():
        print(name, " ".join(f"{value:.3g}" for value in fitted(*measured(*case))), flush=True)


if __name__ == "__main__":
    sys.exit(main())
