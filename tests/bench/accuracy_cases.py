"""What is measured: cases, each a pond, a mesh of its water, what it is judged against, and how it is baked."""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

from dapple.kernels.anchor import Kept
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import prepare, solve
from dapple.kernels.scene import Settings

from . import accuracy_meshes as meshes
from .accuracy_ponds import SEEDS, drawn, pool
from .reference_files import of_mesh, of_waves

RESOLUTION = 512
REPEATS = 5
HEAD = (
    "scene", "water", "triangles", "method", "asked", "CPU [s]", "error", "by squared mean", "own estimate", "energy",
    "books", "reference's error",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """pond; mesh: makes its Water; truth: of_mesh or of_waves; settings; water and method: what the row calls them."""

    pond: Any
    mesh: Any
    truth: Any
    settings: Settings
    water: str
    method: str

    def row(self):
        """The cells of this case's row, in the order of HEAD."""
        water = self.mesh(self.pond)
        reference = of_mesh(self.pond, water, RESOLUTION) if self.truth is of_mesh else of_waves(self.pond, RESOLUTION)
        scene = self.pond.scene(water)
        own = [rasterise(scene.receivers[0], RESOLUTION)]
        kept = Kept(prepare(scene, own, self.settings))
        seconds, solution = timed(lambda: solve(scene, own, self.settings, kept))
        error, by_mean, energy = reference.judge(solution.images[0][:, :, 0])
        estimate = solution.diagnostics.estimated_error
        return (
            self.pond.name, self.water, len(water.triangles), self.method, f"{self.settings.tolerance:.0e}",
            f"{seconds:.3f}", f"{error:.1e}", f"{by_mean:.1e}", "-" if estimate is None else f"{estimate:.1e}",
            f"{100 * energy:+.3f} %", f"{100 * _imbalance(solution.diagnostics):.3f} %", f"{reference.error:.0e}",
        )  # fmt: skip


def timed(run, repeats=REPEATS):
    """Median CPU seconds of `repeats` warm runs, of one where that takes three seconds, and what the last returned."""
    start = time.process_time()
    result = run()
    if time.process_time() - start > 3:
        repeats = 1
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        result = run()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds), result


def _imbalance(diagnostics):
    """What entered less what was received or booked as lost, over what entered, in red."""
    booked = sum(flux[0] for books in (diagnostics.flux_received, diagnostics.flux_lost) for flux in books.values())
    return 1 - booked / diagnostics.flux_in[0]


def ponds():
    """The pool, and waters drawn by seed."""
    return [pool(), *map(drawn, SEEDS)]


def beams(tolerance, surface="auto"):
    return Settings("photon_splat", tolerance, surface=surface)


def same_mesh():
    """Planar floors against the same mesh, with the waves' normals at its vertices."""
    fine = beams(3e-4, "mesh")
    for pond in ponds():
        yield Case(pond, meshes.exact, of_mesh, fine, "regular", "exact coverage")
    yield Case(pool(), partial(meshes.exact, quads=512), of_mesh, fine, "regular", "exact coverage")
    others = [
        ("points", Settings("photon_splat", points=True, surface="mesh")),
        ("first root", Settings("conic_walk", first_root=True, surface="mesh")),
        *(("all roots", Settings("conic_walk", tolerance, surface="mesh")) for tolerance in (1e-1, 1e-2)),
    ]
    for method, settings in others:
        yield Case(pool(), meshes.exact, of_mesh, settings, "regular", method)


def uneven():
    """Uneven terrain against the same mesh."""
    for pond in (pool(), drawn(1)):
        yield Case(pond.with_relief(), meshes.exact, of_mesh, beams(1e-3, "mesh"), "regular", "exact coverage")


def true_waves():
    """Blender's normals against the true waves, as they are and reconstructed."""
    for pond in ponds():
        for method, settings in (("mesh as it is", beams(2e-3, "mesh")), ("reconstructed", beams(2e-3))):
            yield Case(pond, meshes.regular, of_waves, settings, "regular", method)
    for tolerance in (5e-2, 7e-3):
        yield Case(pool(), meshes.regular, of_waves, beams(tolerance), "regular", "reconstructed")


def other_meshes():
    """Irregular and noisy meshes of the pool against the true waves."""
    kinds = {"jittered": meshes.jittered, "blue noise": meshes.blue_noise, "iso-surface": meshes.iso_surface}
    kinds[f"{1e3 * meshes.NOISE} mm noise"] = partial(meshes.regular, noise=meshes.NOISE)
    for name, mesh in kinds.items():
        for method, settings in (("mesh as it is", beams(5e-3, "mesh")), ("reconstructed", beams(5e-3))):
            yield Case(pool(), mesh, of_waves, settings, name, method)


def discs():
    """The sun of 0.53 degrees against the true waves."""
    for pond in (pool(), drawn(2), drawn(5)):
        for tolerance in (1e-2, 2e-3):
            yield Case(pond.with_disc(), meshes.regular, of_waves, beams(tolerance), "regular", "reconstructed")


TABLES = {
    "Against the same mesh, planar floor": same_mesh,
    "Against the same mesh, uneven floor": uneven,
    "Against the true waves": true_waves,
    "Other meshes against the true waves": other_meshes,
    "Against the true waves, the sun 0.53° wide": discs,
}
