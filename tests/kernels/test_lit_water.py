"""What a sun sees of the water, and which of it may lie in a shadow."""

import numpy as np
import pytest
from waves import OBLIQUE, five_sines, floor, grid, mesh_water, sun, water

from dapple.kernels.lit_water import light_water, may_be_shadowed
from dapple.kernels.rays import Tracer


@pytest.mark.parametrize("direction", [(0, 0, -1), OBLIQUE, (1.0, -2.0, -1.0)])
def test_flux_is_the_area_across_the_light(direction):
    lit = light_water(water(five_sines, 40, side=3.0), sun(direction))
    d = np.array(direction) / np.linalg.norm(direction)
    # The rim is not level, so the projected outline, not the plan, is what counts; by Green's theorem.
    one = np.arange(40)
    rim = np.concatenate([one, 41 * one + 40, 1680 - one, 41 * (40 - one)])
    edge = lit.positions[rim]
    x, y = edge[:, 0], edge[:, 1]
    outline = abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2
    assert lit.area.sum() == pytest.approx(outline, rel=1e-12)
    assert lit.area.sum() == pytest.approx(9.0 * -d[2], rel=0.05)


def test_no_shadow_is_missed():
    """A ball of triangles over the water: every triangle of water from which a ray meets it must be marked."""
    rng = np.random.default_rng(0)
    centre = np.array([0.4, -0.3, 2.2])
    positions = centre + rng.normal(size=(60, 3)) * 0.15
    triangles = rng.integers(0, 60, (200, 3))
    w, light = water(five_sines, 48), sun((0.5, -0.3, -1))
    lit = light_water(w, light)
    marked = may_be_shadowed(lit, positions, triangles)
    weights = rng.dirichlet([1, 1, 1], (len(w.triangles), 8))
    points = np.einsum("tsk,tkx->tsx", weights, w.positions[w.triangles])
    blocked = Tracer(positions, triangles).blocked(
        points.reshape(-1, 3), np.tile(lit.frame[2], (points.shape[0] * 8, 1))
    )
    blocked = blocked.reshape(-1, 8).any(1)
    assert blocked.sum() > 20
    assert not (blocked & ~marked).any()
    assert marked.mean() < 0.3, "marking everything is safe but useless"


def test_what_lies_below_shadows_nothing():
    bed = floor()
    lit = light_water(water(five_sines, 16), sun())
    assert not may_be_shadowed(lit, bed.positions, bed.triangles).any()
    assert not may_be_shadowed(lit, np.zeros((0, 3)), np.zeros((0, 3), int)).any()


def test_a_body_of_water_is_lit_on_top_however_its_normals_lean():
    """A closed slab shows as much of its bottom as of its top; a few normals that lean over its rim tip no balance."""
    x, y, top = grid(8, 2.0)
    count = len(x)
    positions = np.concatenate([np.stack([x, y, np.full(count, z)], 1) for z in (0.0, -0.3)])
    along = np.arange(8)
    rim = np.concatenate([along, 8 + 9 * along, 80 - along, 72 - 9 * along])
    a, b = rim, np.roll(rim, -1)
    sides = np.concatenate([np.stack([a, a + count, b], 1), np.stack([b, a + count, b + count], 1)])
    triangles = np.concatenate([top, top[:, ::-1] + count, sides])
    normals = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], count, axis=0)
    normals[rim[:3]] = (0.0, -0.6, -0.8)
    lit = light_water(mesh_water(positions, triangles, normals), sun((0.0, 0.0, -1.0)))
    assert lit.area[len(top) : 2 * len(top)].sum() == 0
    assert lit.area[: len(top)].sum() > 3.5
