"""The error of caustics from meshes, as they are and reconstructed, against the true waves: for docs/surface.md.

Run as `.venv/bin/python tests/bench/bench_surface.py [QUADS]`; it pins itself to one core, prints the table as it goes
and writes it to docs/surface_tables.md. The references are beams from two million triangles with exact normals. Times
are CPU seconds of this process, warm, of one run.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent))

from bench_stages import ROOT, Table, load_dapple, machine

REPEATS = 1
RESOLUTION, SIDE, LEVEL, REFERENCE = 512, 4.8, 1.5, 1024
TOLERANCES = (5e-2, 1e-2)
KINDS = (
    ("regular", 0.0), ("jittered", 0.0), ("blue noise", 0.0), ("iso-surface", 0.0), ("interpolated iso-surface", 0.0),
    ("regular", 5e-5), ("regular", 2e-4), ("regular", 1e-3), ("blue noise", 2e-4),
)  # fmt: skip
COMMAND = "`.venv/bin/python tests/bench/bench_surface.py`"


def random_waves(seed, count=14, shortest=0.2, longest=2.5, height=0.016):
    """`shape(x, y)` of waves drawn by seed: wavelengths and `height`, the root mean square, in metres."""
    import numpy as np

    rng = np.random.default_rng(seed)
    length = np.exp(rng.uniform(np.log(shortest), np.log(longest), count))
    heading, start = rng.uniform(0, 2 * np.pi, (2, count))
    amplitude = length**1.2 * rng.uniform(0.5, 1, count)
    amplitude *= height * np.sqrt(2 / (amplitude**2).sum())
    k = 2 * np.pi / length

    def shape(x, y):
        phase = k * (x[..., None] * np.cos(heading) + y[..., None] * np.sin(heading)) + start
        slope = amplitude * k * np.cos(phase)
        z = (amplitude * np.sin(phase)).sum(-1)
        return z, (slope * np.cos(heading)).sum(-1), (slope * np.sin(heading)).sum(-1)

    return shape


def waters():
    """name -> (shape, direction of the sun, depth [m])."""
    from waves import OBLIQUE, five_sines

    return {
        "five sines, 1.5 m": (five_sines, OBLIQUE, 1.5),
        "seed 7, 2.5 m, overhead": (random_waves(7), (0.0, 0.0, -1.0), 2.5),
        "seed 8, 1 m, sun at 45 degrees": (random_waves(8, height=0.01), (0.8, -0.6, -1.0), 1.0),
    }


def solved(water, direction, depth, settings, kept=None):
    """(image, Diagnostics) of a floor `depth` under LEVEL."""
    from waves import floor, sun

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Scene

    bed = floor(z=LEVEL - depth)
    scene = Scene(water, (bed,), (), (sun(direction),))
    answer = solve(scene, [rasterise(bed, RESOLUTION)], settings, kept)
    return answer.images[0][..., 0], answer.diagnostics


def cpu(run):
    """(least CPU seconds, result) of run(), after one more before."""
    run()
    best = float("inf")
    for _ in range(REPEATS):
        start = time.process_time()
        result = run()
        best = min(best, time.process_time() - start)
    return best, result


def _surface(water, depth, settings, reconstruction):
    """Least CPU seconds of the reconstruction alone."""
    from waves import floor

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Scene
    from dapple.kernels.surface.reconstruct import Need

    bed = floor(z=LEVEL - depth)
    own = [rasterise(bed, RESOLUTION)]
    return cpu(lambda: reconstruction.apply(water, Need.of(Scene(water, (bed,), (), ()), own, settings.tolerance)))[0]


def errors(image, true):
    """Mean squared error over the mean square, as the tolerance is, and over the squared mean, as text."""
    squared = ((image - true) ** 2).mean()
    return f"{squared / (true**2).mean():.2g}", f"{squared / true.mean() ** 2:.2g}"


def rows(quads):
    """Rows of the table: one per water, mesh and setting."""
    from water_meshes import make
    from waves import water as exact_water

    from dapple.kernels.anchor import Anchor, Kept
    from dapple.kernels.scene import Settings
    from dapple.kernels.surface.reconstruct import prepared

    for name, (shape, direction, depth) in waters().items():
        fine = exact_water(shape, REFERENCE, SIDE, LEVEL)
        true, _ = solved(fine, direction, depth, Settings(tolerance=1e-5, surface="mesh"))
        for kind, noise in KINDS:
            mesh = make(kind, shape, quads, SIDE, LEVEL, noise)
            what = f"{kind}, {noise * 1e3:g} mm of noise" if noise else kind
            for tolerance in (None, *(TOLERANCES if not noise else TOLERANCES[1:2])):
                settings = Settings(tolerance=tolerance or 1e-3, surface="auto" if tolerance else "mesh")
                shared = Kept(Anchor(prepared(mesh)))
                seconds, (image, said) = cpu(lambda: solved(mesh, direction, depth, settings, shared))  # noqa: B023
                text = said.surface.replace("B-splines over the plan, ", "") if tolerance else "as it is"
                of = f"{len(mesh.triangles) / 1e3:.0f}k"
                energy = f"{image.mean() / true.mean() - 1:+.1e}"
                surface = f"{_surface(mesh, depth, settings, shared.reconstruction):.3f}" if tolerance else "0"
                yield name, what, of, tolerance or "", text, *errors(image, true), energy, surface, f"{seconds:.2f}"


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[-1]})
    load_dapple()
    quads = int(sys.argv[1]) if len(sys.argv) > 1 else 128
    table = Table()
    table.head(
        "water", "mesh", "triangles", "tolerance", "surface", "error", "by squared mean", "energy",
        "of that, surface [s]", "all [s]",
    )  # fmt: skip
    for row in rows(quads):
        table.add(*row)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "surface_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    main()
