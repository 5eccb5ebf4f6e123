"""The constants of `kernels/plan/cost.py`: microseconds to begin with, for a triangle, for a texel.

Run as `.venv/bin/python tests/bench/bench_costs.py`; it pins itself to one core and prints them.
"""

from __future__ import annotations

import os
import sys
from functools import partial

import numpy as np
from bench_stages import load_dapple

QUADS, SIDES = (48, 96, 192), (96, 192, 384)


def measured(pond, settings):
    """(1, triangles, texels) (n,3) and CPU seconds (n,) of solves of a Pond."""
    from bench.accuracy_cases import timed
    from bench.estimate_ponds import water_of

    from dapple.kernels.anchor import Anchor, Kept
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.surface.smoothing import Smoothing

    counts, seconds = [], []
    kept = Kept(Anchor(Smoothing(0.002, 10.0)))
    for quads in QUADS:
        scene = pond.scene(water_of(pond, quads))
        for side in SIDES:
            own = [rasterise(scene.receivers[0], side)]
            counts.append((1, 2 * quads**2, side**2))
            seconds.append(timed(partial(solve, scene, own, settings, kept), 3)[0])
    return np.array(counts, float), np.array(seconds)


def fitted(counts, seconds):
    """The constants (3,) [microseconds], none below 0, of the least relative error."""
    used = [0, 1, 2]
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
    from bench.accuracy_ponds import pool

    from dapple.kernels.scene import Settings

    mesh = Settings("photon_splat", 1e-2, without=("reconstruction",))
    cases = {
        "FLAT": (pool(), Settings("flat", without=("occlusion",))),
        "FLAT_BY_RAYS": (pool().with_relief(), Settings("flat", without=("occlusion",))),
        "BEAMS": (pool(), mesh),
        "BEAMS_BY_RAYS": (pool().with_relief(), mesh),
        "BEAMS and DISC": (pool().with_disc(), mesh),
        "BEAMS and SURFACE": (pool(), Settings("photon_splat", 0.5)),
    }
    for name, case in cases.items():
        print(name, " ".join(f"{value:.3g}" for value in fitted(*measured(*case))), flush=True)


if __name__ == "__main__":
    sys.exit(main())
