"""Light stays on the side of a wall that it falls on: two rooms and one wall between them, one sheet or a box."""

import numpy as np
import pytest
from casters import ball, no_water
from waves import calm, five_sines, floor, pool, quad, sun, turned

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Receiver, Scene, Settings

SIDE = 64
methods = pytest.mark.parametrize(
    "how", [{}, {"points": True}, {"method": "conic_walk"}], ids=["beams", "points", "walk"]
)


def bake(scene, how, shape=SIDE):
    texels = [rasterise(r, shape) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=1e-2, surface="mesh", **how))


def wall(x, low=0.0, high=3.0, half=2.4):
    """An upright sheet across x, its front towards -x."""
    return turned(quad("Wall", [[x, -half, low], [x, half, low], [x, half, high], [x, -half, high]]))


def rooms(between, direction):
    """A floor under waves, roofed for x > 0: a room that is lit and one that is dark, and what stands between them."""
    roof = quad("Roof", [[0, -3, 2.99], [3, -3, 2.99], [3, 3, 2.99], [0, 3, 2.99]])
    roof = Occluder("Roof", roof.positions, roof.triangles)
    return pool(calm, 48, direction, [floor(), *between], [roof])


@methods
def test_a_single_sheet_keeps_the_dark_room_dark(how):
    """The sun slants into the sheet. Nothing passes it, and nothing shows on its other side or behind it."""
    lit, dark = wall(0.0), turned(wall(0.0))
    direction = (0.5, 0.1, -1.0)
    front, back = (bake(rooms([sheet], direction), how) for sheet in (lit, dark))
    assert front.images[1].mean() > 0.05
    assert not back.images[1].any(), "the back of the sheet is lit, its front is in the dark room"
    for answer in (front, back):
        behind = answer.images[0][:, SIDE // 2 + 1 :]
        assert not behind.any()
        assert answer.images[0][:, : SIDE // 2 - 1].mean() > 0.1
    if "method" not in how:
        booked = back.diagnostics.flux_lost["back"]
        np.testing.assert_allclose(booked, front.diagnostics.flux_received["Wall"], rtol=0.02)


def slab(half):
    """A wall of two sheets, `half` to each side of x = 0, closed above, in one map: left, right and top."""
    left, right = wall(-half), turned(wall(half))
    top = quad("Top", [[-half, -2.4, 3.0], [half, -2.4, 3.0], [half, 2.4, 3.0], [-half, 2.4, 3.0]])
    low, high = np.array([0.02, 0.02]), np.array([0.3, 0.98])
    uvs = [part.uvs * (high - low) + low + [k / 3, 0] for k, part in enumerate((left, right, top))]
    triangles = np.concatenate([part.triangles + 4 * k for k, part in enumerate((left, right, top))])
    positions = np.concatenate([part.positions for part in (left, right, top)])
    return Receiver("Slab", positions, triangles, np.concatenate(uvs))


@methods
@pytest.mark.parametrize("half", [0.05, 1e-3])
def test_a_thin_box_is_lit_on_its_lit_side_only(how, half):
    """A millimetre is far less than a texel: two charts of one map, a hair apart in the world."""
    answer = bake(rooms([slab(half)], (0.5, 0.1, -1.0)), how)
    own, image = rasterise(slab(half), SIDE), answer.images[1].reshape(-1, 3)
    side = own.chart[own.triangle]
    left, right = (image[own.texel[side == own.chart[k]]] for k in (0, 2))
    assert left.mean() > 0.05
    assert not right.any()
    assert not answer.images[0][:, SIDE // 2 + 2 :].any()


@pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])
def test_what_falls_on_backs_is_booked(points):
    """The floor turned over: all that it received is booked as what comes to its back."""
    how = {"points": points}
    answer = bake(pool(five_sines, 48), how)
    over = bake(pool(five_sines, 48, receivers=[turned(floor())]), how)
    assert not over.images[0].any()
    received = answer.diagnostics.flux_received["Floor"]
    np.testing.assert_allclose(over.diagnostics.flux_lost["back"], received, rtol=5e-3)
    for done in (answer, over):
        total = sum(done.diagnostics.flux_received.values()) + sum(done.diagnostics.flux_lost.values())
        np.testing.assert_allclose(total, done.diagnostics.flux_in, rtol=1e-9)


def glass_rooms(between):
    """No water: a glass ball in the lit room, close to what stands between it and the dark one."""
    casters = (ball(0.25, (-0.35, 0.0, 0.5), fine=48),)
    return Scene(no_water(), (floor(), *between), (), (sun((0.9, 0.1, -1.0)),), casters=casters)


@pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])
@pytest.mark.parametrize("between", [wall(0.0), slab(1e-3)], ids=["sheet", "box"])
def test_what_glass_throws_at_a_wall_stays_on_its_side(between, points):
    """The ball's focus lies on the wall's foot: nothing of it behind the wall, nor on its other side."""
    answer = bake(glass_rooms([between]), {"points": points})
    assert not answer.images[0][:, SIDE // 2 + 1 :].any()
    own = rasterise(between, SIDE)
    light = answer.images[1].reshape(-1, 3)[own.texel, 0]
    assert light.max() > 1.0
    assert not light[own.normals[:, 0] > 0.5].any()
    over = bake(glass_rooms([turned(between)]), {"points": points}).diagnostics
    lit = answer.diagnostics.flux_received[between.name]
    np.testing.assert_allclose(over.flux_lost["back"], lit, rtol=0.03)
