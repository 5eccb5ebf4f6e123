"""What the methods cost: steps and roots of the conic walk, and time against triangles and texels with exponents."""

from __future__ import annotations

import numpy as np

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.rays import soup
from dapple.kernels.scene import Settings
from dapple.kernels.walk.paths import LightPaths
from dapple.kernels.walk.walkers import Walk

from .accuracy_cases import timed
from .accuracy_meshes import exact
from .accuracy_ponds import pool
from .bench_stages import step_cost

QUADS = 32, 64, 128, 256, 512, 1000  # 2 thousand to 2 million triangles
RESOLUTIONS = 128, 256, 512, 1024, 2048
_REPEATS = 3
_LONGEST = 1024  # the walk's map: it takes the time of all the other runs beyond
METHODS = {
    "exact coverage": Settings("photon_splat", surface="mesh"),
    "all roots": Settings("conic_walk", tolerance=0.1, surface="mesh"),
    "first root": Settings("conic_walk", first_root=True, surface="mesh"),
}
STEP_HEAD = "triangles", "points", "ns per triangle step", "steps [M]"
WALK_HEAD = "method", "triangles", "resolution", "asked", "CPU [s]", "own estimate"
PEAK_HEAD = "method", "triangles", "resolution", "CPU [s], once", "most memory [GB]"


def run(name, quads, resolution, repeats=_REPEATS):
    """Median CPU seconds of a bake of the pool by a method of METHODS, warm, and the Solution."""
    scene = pool().scene(exact(pool(), quads))
    own = [rasterise(scene.receivers[0], resolution)]
    return timed(lambda: solve(scene, own, METHODS[name]), repeats)


def step_rows():
    """Rows for STEP_HEAD: the walk to the first root, its steps alone."""
    for quads in (128, 512):
        scene = pool().scene(exact(pool(), quads))
        points = rasterise(scene.receivers[0], 512).positions
        paths = LightPaths(scene, scene.lights[0], None, soup(scene.receivers))
        at = paths.lit.frame @ points.T
        cost, steps = step_cost(Walk, paths.surface, at, paths.first_water(points), scene.eta)
        yield 2 * quads**2, len(points), f"{cost:.0f}", f"{steps / 1e6:.1f}"


def walk_rows():
    """Rows for WALK_HEAD."""
    for name, quads, resolution in (
        ("first root", 128, 512), ("first root", 512, 512), ("all roots", 128, 512), ("all roots", 128, 1024),
    ):  # fmt: skip
        seconds, solution = run(name, quads, resolution)
        estimate = solution.diagnostics.estimated_error
        asked, said = (f"{METHODS[name].tolerance:.0e}", f"{estimate:.1e}") if estimate is not None else ("-", "-")
        yield name, 2 * quads**2, resolution, asked, f"{seconds:.2f}", said


def measure_costs():
    """{method: (triangles, seconds, texels, seconds)}."""
    costs = {}
    for name in METHODS:
        sides = [r for r in RESOLUTIONS if name == "exact coverage" or r <= _LONGEST]
        by_quads = [run(name, quads, 512)[0] for quads in QUADS]
        by_side = [by_quads[QUADS.index(128)] if side == 512 else run(name, 128, side)[0] for side in sides]
        costs[name] = 2.0 * np.square(QUADS), np.array(by_quads), np.square(sides, dtype=float), np.array(by_side)
    return costs


def fit(count, seconds):
    """(c, a, p) of seconds = c + a count^p, c >= 0, with the least relative error."""
    best = None
    for p in np.arange(0.3, 1.81, 0.01):
        columns = np.stack([np.ones_like(count), (count / count[-1]) ** p], 1) / seconds[:, None]
        for c_too in (True, False):
            used = columns if c_too else columns[:, 1:]
            found, *_ = np.linalg.lstsq(used, np.ones(len(count)), rcond=None)
            off = ((used @ found - 1) ** 2).sum()
            c, a = found if c_too else (0.0, found[0])
            if c >= 0 and a > 0 and (best is None or off < best[0]):
                best = off, c, a / count[-1] ** p, p
    return best[1:]


def draw(costs, path):
    """The figure: seconds against triangles and against texels, with the fits."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.4), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for name, values in costs.items():
        for axis, count, seconds in zip(axes, values[::2], values[1::2], strict=True):
            c, a, p = fit(count, seconds)
            line = axis.loglog(count, seconds, "o")[0]
            fine = np.geomspace(count[0], count[-1], 100)
            power = f"{a * 1e6**p:.2g} s (n / 1e6)^{p:.2f}"
            axis.loglog(fine, c + a * fine**p, color=line.get_color(), label=f"{name}: {c:.2g} s + {power}")
    for axis, what in zip(axes, ("triangles of the water, 512 x 512 texels", "texels, 32,768 triangles"), strict=True):
        axis.set_xlabel(what)
        axis.grid(True, which="major", alpha=0.3)
        axis.legend(fontsize=8, loc="upper left")
    axes[0].set_ylabel("CPU seconds, one core")
    figure.savefig(path, dpi=110)
