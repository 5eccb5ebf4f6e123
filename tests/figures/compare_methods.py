"""Close-ups of the pool by every method beside the references of the benchmark, and what they differ by.

Run as `.venv/bin/python tests/figures/compare_methods.py`; it writes docs/images/methods.png and surface.png. It takes
about half a minute, and twice that if tests/bench/references lacks what it shows.
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.colors import CenteredNorm, PowerNorm
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
CROP = slice(190, 318), slice(230, 358)  # rows and columns of 512: 1 x 1 m
BRIGHTEST, WIDEST = 6.0, 3.0  # W/m^2, of light and of differences


def solved(pond, water, settings):
    """Irradiance (H,W) on the floor of a Pond under a Water."""
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve

    scene = pond.scene(water)
    own = [rasterise(scene.receivers[0], settings.resolution)]
    return solve(scene, own, settings).images[0][:, :, 0]


def draw(title, reference, images, path):
    """The reference and the images {name: (H,W)} in one row, what they differ by in the next."""
    figure = Figure(figsize=(3.1 * (len(images) + 1) + 0.8, 6.6), layout="constrained")
    figure.suptitle(title)
    axes = figure.subplots(2, len(images) + 1)
    light = {"cmap": "inferno", "norm": PowerNorm(0.5, 0, BRIGHTEST), "origin": "lower"}
    shown = axes[0, 0].imshow(reference.image[CROP], **light)
    axes[0, 0].set_title("reference")
    for (above, below), (name, image) in zip(axes[:, 1:].T, images.items(), strict=True):
        error, _, energy = reference.judge(image)
        above.imshow(image[CROP], **light)
        above.set_title(name)
        off = below.imshow((image - reference.image)[CROP], cmap="RdBu_r", norm=CenteredNorm(0, WIDEST), origin="lower")
        below.set_title(f"difference: error {error:.1e}, light {100 * energy:+.2f} %", fontsize=9)
    axes[1, 0].axis("off")
    for axis in axes.flat:
        axis.set_xticks([])
        axis.set_yticks([])
    figure.colorbar(shown, ax=axes[0], label="W/m²", extend="max", shrink=0.9)
    figure.colorbar(off, ax=axes[1], label="W/m²", extend="both", shrink=0.9)
    figure.savefig(path, dpi=74, pil_kwargs={"optimize": True})


def main():
    """Write both pictures."""
    from bench_stages import load_dapple

    load_dapple()
    from bench import accuracy_meshes as meshes
    from bench.accuracy_ponds import pool
    from bench.reference_files import of_mesh, of_waves

    from dapple.kernels.scene import Settings

    pond, side = pool(), 512
    water = meshes.exact(pond)
    settings = {
        "conic walk, first root": Settings("conic_walk", surface="mesh", first_root=True),
        "conic walk, all roots": Settings("conic_walk", surface="mesh"),
        "exact coverage": Settings("photon_splat", surface="mesh"),
    }
    draw(
        "1 x 1 m of the pool's floor at 512 x 512, 32,768 triangles, against the same mesh",
        of_mesh(pond, water, side),
        {name: solved(pond, water, s) for name, s in settings.items()},
        ROOT / "docs" / "images" / "methods.png",
    )
    water = meshes.regular(pond)
    draw(
        "1 x 1 m of the pool's floor at 512 x 512, 32,768 triangles with Blender's normals, against the true waves",
        of_waves(pond, side),
        {
            "the mesh as it is": solved(pond, water, Settings("photon_splat", surface="mesh")),
            "the surface reconstructed": solved(pond, water, Settings("photon_splat", tolerance=2e-3)),
        },
        ROOT / "docs" / "images" / "surface.png",
    )


if __name__ == "__main__":
    main()
