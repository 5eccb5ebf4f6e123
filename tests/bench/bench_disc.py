"""The blur by the sun's disc against the sum over many suns of no width, on the same mesh: the table of docs/disc.md.

Run as `.venv/bin/python tests/bench/bench_disc.py`; it pins itself to one core, takes some two minutes, prints the
table as it goes and writes it to docs/disc_tables.md. The suns share the beams with what is judged, but no blur. Errors
are over the mean square, as the tolerance is.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from functools import partial

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_disc.py`"
SUNS = 150
TOLERANCES = (1e-1, 1e-2, 1e-3)
HEAD = (
    "scene", "sun", "resolution", "half axis [texel]", "without the disc", "asked", "cells a texel", "error",
    "own estimate", "blur [s]", "CPU [s]",
)  # fmt: skip


def cases():
    """Ponds, angles [degrees] of the sun, and resolutions."""
    from bench.accuracy_ponds import drawn, pool

    for angle, resolution in ((0.53, 512), (0.53, 256), (1.06, 256), (2.12, 256)):
        yield pool(), angle, resolution
    for seed in (2, 3, 5):
        yield drawn(seed), 0.53, 256


def rows(pond, angle, resolution):
    """The cells of the rows of one case, one row a tolerance."""
    import numpy as np
    from bench.accuracy_cases import timed
    from bench.accuracy_meshes import exact

    from dapple.kernels.disc.disc import Disc, within_disc
    from dapple.kernels.disc.moments import ellipses
    from dapple.kernels.lit_water import light_water
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Settings

    scene = pond.scene(exact(pond))
    sun = replace(scene.lights[0], angle=np.radians(angle))
    texels = [rasterise(scene.receivers[0], resolution)]

    def bake(light, tolerance=1e-3):
        settings = Settings("photon_splat", tolerance, surface="mesh")
        return solve(replace(scene, lights=(light,)), texels, settings)

    true = sum(bake(one).images[0] for one in within_disc(sun, SUNS, np.random.default_rng(1))) / SUNS

    def error(answer):
        return f"{((answer.images[0] - true) ** 2).mean() / (true**2).mean():.1e}"

    about = (light_water(scene.water, sun), scene.receivers, texels, pond.eta, sun.angle / 2)
    size = 2 * np.sqrt(ellipses(*about)[0][:2].sum(0).mean() / 2)
    sharp = error(bake(replace(sun, angle=0.0)))
    for tolerance in TOLERANCES:
        seconds, answer = timed(partial(bake, sun, tolerance))
        disc = Disc(*about, tolerance)
        blur, _ = timed(partial(disc.blur, np.ones((1, (disc.grain * resolution) ** 2))))
        yield (
            pond.name, f"{angle}°", resolution, f"{size:.2f}", sharp, f"{tolerance:.0e}", disc.grain, error(answer),
            f"{answer.diagnostics.estimated_error:.1e}", f"{blur:.3f}", f"{seconds:.3f}",
        )  # fmt: skip


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    table = Table()
    table.head(*HEAD)
    for case in cases():
        for row in rows(*case):
            table.add(*row)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "disc_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
