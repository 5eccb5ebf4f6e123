"""The smooth water that a mesh samples is never a worse surface than the mesh, whatever the mesh.

The truth is a mesh many times as fine, with exact normals; the coarse one has the normals that Blender gives it.
"""

from dataclasses import replace

import numpy as np
import pytest
from waves import calm, five_sines, flat, mesh_water, pool, water

from dapple.tests.stability.constructions import curl, droplets, joined, with_triangles
from dapple.tests.stability.judge import Verdict, run

SIDE = 64
COARSE, FINE = 48, 384


def shaded(surface):
    """The water with the mean of its facets' normals, as meshes come."""
    v = surface.positions[surface.triangles]
    facets = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    normals = np.zeros_like(surface.positions)
    for k in range(3):
        np.add.at(normals, surface.triangles[:, k], facets)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return mesh_water(surface.positions, surface.triangles, normals)


def part(surface, inside):
    """The triangles whose middles are inside(x, y)."""
    x, y, _ = surface.positions[surface.triangles].mean(1).T
    return with_triangles(surface, surface.triangles[inside(x, y)])


def jittered(quads):
    """Waves on a grid whose vertices lie anywhere within 0.3 of a quad of their place."""
    grid = water(flat, quads)
    move = np.random.default_rng(5).uniform(-0.3, 0.3, (len(grid.positions), 2)) * 4.8 / quads
    x, y = (grid.positions[:, :2] + move * (np.abs(grid.positions[:, :2]).max(1, keepdims=True) < 2.39)).T
    height, slope_x, slope_y = five_sines(x, y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], 1)
    return mesh_water(np.stack([x, y, 1.5 + height], 1), grid.triangles, normals)


def noisy(quads):
    """Waves with noise of 0.2 mm; the finest mesh has none."""
    surface = water(five_sines, quads)
    noise = np.random.default_rng(6).normal(0, 2e-4, len(surface.positions)) * (quads < FINE)
    positions = surface.positions + noise[:, None] * np.array([0, 0, 1.0])
    return mesh_water(positions, surface.triangles, surface.normals)


def two_meshes(quads):
    """Two meshes of unlike spacing side by side, no vertex shared."""
    return joined(
        part(water(five_sines, quads), lambda x, y: x < 0), part(water(five_sines, 2 * quads), lambda x, y: x > 0)
    )


WATERS = {
    "waves": lambda n: water(five_sines, n),
    "with a rim over the floor": lambda n: water(five_sines, n, 2.8),
    "with a hole": lambda n: part(water(five_sines, n), lambda x, y: np.maximum(abs(x), abs(y)) > 0.4),
    "of two meshes that do not fit": two_meshes,
    "on a jittered mesh": jittered,
    "with 0.2 mm of noise": noisy,
    "that leans": lambda n: curl(0.1, n + 1, n + 1, 4.8),
    "that overhangs": lambda n: curl(0.3, n + 1, n + 1, 4.8),
    "under droplets": lambda n: joined(water(calm, n), *droplets()),
}


@pytest.mark.parametrize("name", WATERS)
def test_smooth_water_is_no_worse_than_its_mesh(row, name):
    """The smooth water that a mesh samples

    Against the waves that both sample, the map of the smooth water has no more error than that of the raw mesh.
    """
    build = WATERS[name]
    truth = run(replace(pool(flat, quads=2), water=build(FINE)), SIDE, "beams").images[0][..., 0]
    scene = replace(pool(flat, quads=2), water=shaded(build(COARSE)))
    errors = {}
    for surface in ("mesh", "auto"):
        image = run(scene, SIDE, "beams", surface).images[0][..., 0]
        errors[surface] = ((image - truth) ** 2).mean() / truth.mean() ** 2
    row.tolerance = f"{errors['auto']:.0e}, mesh {errors['mesh']:.0e}"
    row.cells["beams"] = Verdict("right" if errors["auto"] <= errors["mesh"] else "wrong", "", errors["auto"])
    assert errors["auto"] <= errors["mesh"], errors
