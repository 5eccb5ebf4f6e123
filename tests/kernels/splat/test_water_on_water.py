"""Water that shades water and light that meets it twice, through the whole estimator, against closed forms."""

import numpy as np
import pytest
from waves import five_sines, flat, floor, mesh_water, sun, transmitted, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Scene, Settings, Water
from dapple.kernels.splat.photon_splat import solve

either = pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])


def bake(scene, resolution=32, tolerance=1e-3, points=False):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=tolerance, points=points)).diagnostics


def facets(positions, triangles):
    """Flat-shaded Water."""
    v = positions[triangles]
    normals = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(normals))[:, None], 3, 1)
    return Water("Facets", positions, triangles, normals, rows, build_twins(triangles))


def tank(thickness=0.4):
    """A closed slab of water, 2 m wide, its underside at 1 m: top, underside wound to look down, and four sides."""
    top, under = water(flat, 12, 2.0, 1.0 + thickness), water(flat, 12, 2.0, 1.0)
    count = len(top.positions)
    one = np.arange(12)
    rim = np.concatenate([one, 13 * one + 12, 168 - one, 13 * (12 - one)])
    after = np.roll(rim, -1)
    sides = [np.stack([rim, rim + count, after + count], 1), np.stack([rim, after + count, after], 1)]
    triangles = np.concatenate([top.triangles, under.triangles[:, ::-1] + count, *sides])
    return facets(np.concatenate([top.positions, under.positions]), triangles)


def books(d):
    return sum(d.flux_received.values()) + sum(d.flux_lost.values())


@either
def test_light_goes_through_a_tank_by_top_and_underside(points):
    """Overhead sun: each face passes T; what the underside turns back is the weaker part, and is booked."""
    d = bake(Scene(tank(), (floor(),), (), (sun((0, 0, -1)),)), points=points)
    passed = 1 - ((1.333 - 1) / (1.333 + 1)) ** 2
    np.testing.assert_allclose(d.flux_received["Floor"], 4 * passed**2, rtol=1e-5)
    np.testing.assert_allclose(d.flux_lost["second_meeting"], 4 * passed * (1 - passed), rtol=1e-4)
    np.testing.assert_allclose(d.flux_lost["reflected"], 4 * (1 - passed), rtol=1e-4)
    np.testing.assert_allclose(books(d), d.flux_in, rtol=1e-12)
    assert d.paths["rays_that_meet_the_water_again"] > 0
    assert any("meets the water twice" in sentence for sentence in d.left_out)


@either
def test_a_slanted_sun_leaves_the_tank_as_it_came(points):
    """Parallel faces: the light on the floor is as bright as T^2 cos i says, in the tank's own outline moved."""
    light = sun((0.6, 0, -1))
    cos_i = -light.direction[2]
    scene = Scene(tank(0.1), (floor(side=8.0),), (), (light,))
    image = solve(scene, [rasterise(floor(side=8.0), 64)], Settings(tolerance=1e-3, points=points)).images[0]
    middle = image[28:36, 37:43].mean()  # 0.6 m downstream, away from what the far side turns back
    assert middle == pytest.approx(transmitted(cos_i) ** 2 * cos_i, rel=1e-2 if points else 1e-6)


@either
def test_of_two_sheets_the_upper_takes_the_light(points):
    """Open water above open water: light is in it after the first, and the second lies in its shadow."""
    low, high = water(flat, 8, 2.0, 1.0), water(flat, 8, 1.0, 1.5)
    both = mesh_water(
        np.concatenate([low.positions, high.positions]),
        np.concatenate([low.triangles, high.triangles + len(low.positions)]),
        np.concatenate([low.normals, high.normals]),
    )
    d = bake(Scene(both, (floor(),), (), (sun((0, 0, -1)),)), points=points)
    passed = 1 - ((1.333 - 1) / (1.333 + 1)) ** 2
    np.testing.assert_allclose(d.flux_in, 5.0, rtol=1e-12)
    np.testing.assert_allclose(d.flux_lost["shadowed_by_water"], 1.0, rtol=0.02)
    np.testing.assert_allclose(d.flux_received["Floor"], 4 * passed, rtol=0.01)
    np.testing.assert_allclose(books(d), d.flux_in, rtol=1e-12)


def crests(slope=0.6):
    """Sawtooth water along x, 1 m long each: up over 0.9 m by a tenth of the slope, down over 0.1 m."""
    x = np.unique(np.concatenate([np.arange(-3, 4) + k for k in (0.0, 0.9)] + [np.linspace(-3, 3, 241)]).round(9))
    x = x[(x >= -3) & (x <= 3)]
    y = np.linspace(-3, 3, 5)
    part = (x + 3) % 1.0
    height = np.where(part <= 0.9, slope * part / 9, slope * (1 - part))
    gx, gy = np.meshgrid(x, y)
    i = np.arange(len(x) * 4).reshape(4, len(x))[:, :-1].ravel()
    quad = np.stack([i, i + 1, i + len(x) + 1, i + len(x)], 1)
    positions = np.stack([gx.ravel(), gy.ravel(), np.tile(1.5 + height, len(y))], 1)
    return facets(positions, quad[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))


@either
def test_crests_shade_what_lies_behind_them(points):
    """Light travels to +x under 8 degrees: it sees an outline from the near rim to the last crest, 6 cm high at 2.9 m,
    and all that is more of the water lies in shadow."""
    rise = np.radians(8)
    light = sun((np.cos(rise), 0, -np.sin(rise)))
    d = bake(Scene(crests(), (floor(),), (), (light,)), points=points)
    seen = 6.0 * (5.9 * np.sin(rise) + 0.06 * np.cos(rise))
    np.testing.assert_allclose(d.flux_in - d.flux_lost["shadowed_by_water"], seen, rtol=5e-3)
    np.testing.assert_allclose(books(d), d.flux_in, rtol=1e-12)


@either
def test_a_pool_under_a_high_sun_is_as_it_was(points):
    """No ray meets the water again: nothing is booked for it, and nothing is said."""
    scene = Scene(water(five_sines, 32), (floor(),), (), (sun(),))
    d = bake(scene, points=points, tolerance=1e-2)
    assert set(d.paths) == {"photons" if points else "beams"}
    assert not d.flux_lost.get("second_meeting", np.zeros(3)).any()
    assert not any("twice" in sentence for sentence in d.left_out)
