"""The same square metre of the pool's floor by every rung of the ladder, with its error and its time.

Run as `.venv/bin/python tests/figures/draw_ladder.py`; it writes docs/images/ladder.png and takes about two minutes, on
one core. Errors are as Settings.tolerance counts them, over all receivers, against the chart's reference.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "bench"), str(ROOT / "tests")]
RESOLUTION = 512
CROP = slice(150, 278), slice(230, 358)  # rows and columns of the floor's map: 1 x 1 m
BRIGHTEST = 14.0  # W/m^2
# name, what it is, Settings
RUNGS = (
    ("flat", "still water", {"method": "flat"}),
    ("sun_map", "a look, not the light", {"method": "sun_map"}),
    ("caustic_map", "splats of 512 x 512 points", {"method": "caustic_map", "grid": 512}),
    ("conic_walk, first root", "one path a texel", {"method": "conic_walk", "first_root": True}),
    ("photon_splat, the mesh as it is", "all paths off the facets", {"method": "photon_splat", "surface": "mesh"}),
    ("conic_walk", "all paths to points of each texel", {"method": "conic_walk"}),
    ("photon_splat", "all paths, smooth water", {"method": "photon_splat"}),
)


def last(steps):
    """What a generator returns."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def measured():
    """(name, note, image (H,W,3), error, seconds) of each rung and, at last, of the reference."""
    from bench.sample_scenes import read

    from dapple.kernels.anchor import Kept
    from dapple.kernels.chart.clock import timed
    from dapple.kernels.chart.maps import light_of
    from dapple.kernels.chart.reference import reference
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import prepare, solve
    from dapple.kernels.scene import Settings

    scene = read("pool")
    texels = tuple(rasterise(receiver, RESOLUTION) for receiver in scene.receivers)
    truth = last(reference(scene, texels, Settings(resolution=RESOLUTION)))
    for name, note, changed in RUNGS:
        settings = Settings(resolution=RESOLUTION, tolerance=1e-2, **changed)
        kept = Kept(prepare(scene, texels, settings))
        seconds, solution, _ = timed(lambda settings=settings, kept=kept: solve(scene, texels, settings, kept))
        error = truth.maps.error(light_of(texels, solution.images))
        print(f"{name}: {error:.2g}, {seconds:.3g} s", flush=True)
        yield name, note, solution.images[0], error, seconds
    count = len(texels[0].texel)
    yield "reference", f"2 x {truth.suns} suns in the disc", texels[0].image(truth.maps.light[:count]), truth.error, 0.0


def main():
    """Write the picture."""
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    import conftest  # noqa: F401 - it makes the tree importable as `dapple`, without Blender

    pictures = list(measured())
    figure = Figure(figsize=(12.4, 7.6))
    figure.subplots_adjust(left=0.01, right=0.99, top=0.96, bottom=0.07, wspace=0.03, hspace=0.2)
    for axis, (name, note, image, error, seconds) in zip(figure.subplots(2, 4).flat, pictures, strict=True):
        axis.imshow(image[CROP].mean(2), cmap="inferno", norm=PowerNorm(0.5, 0, BRIGHTEST), origin="lower")
        axis.set_title(name, fontsize=11, fontweight="bold", loc="left")
        cost = f"error {error:.2g}, {seconds:.2f} s" if seconds else f"error {error:.1g}"
        axis.set_xlabel(f"{note}\n{cost}", fontsize=10, loc="left")
        axis.set_xticks([])
        axis.set_yticks([])
    figure.savefig(ROOT / "docs" / "images" / "ladder.png", dpi=80, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    sys.exit(main())
