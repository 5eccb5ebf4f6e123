"""Which medium is where: bodies that overlap, hold cavities or lie in each other, and lamps within them."""

from dataclasses import replace

import numpy as np
import pytest
from caster_rays import at_height, follow, scene, through_a_ball
from casters import SILVER, ball, inside_out, joined, no_water, prism, room, slab
from waves import flat, floor, water

from dapple.kernels.casters import Glass
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Point, Scene, Settings
from dapple.kernels.trace.cast import over_casters
from dapple.kernels.trace.media import Media

GREEN = Glass(1.5, np.array([2.0, 0.5, 1.0]))
DOWN = (0.4, 0.1, -1)


@pytest.mark.parametrize("make", [lambda *c: c, lambda *c: (joined(*c),)], ids=["two meshes", "one mesh"])
@pytest.mark.parametrize("word", [0b111, 0b11001, 0b10])
def test_two_slabs_that_overlap_are_one(make, word):
    parts = slab((-9, -9, 0), (9, 9, 0.5), GREEN), slab((-8, -8, 0.3), (8, 8, 0.7), GREEN)
    whole, _ = follow(scene(slab((-9, -9, 0), (9, 9, 0.7), GREEN)), [(0, 0.1, 1.0)], [DOWN], word)
    for order in (parts, parts[::-1]):
        rays, _ = follow(scene(*make(*order)), [(0, 0.1, 1.0)], [DOWN], word)
        np.testing.assert_allclose(rays.direction, whole.direction, atol=1e-12)
        np.testing.assert_allclose(at_height(rays, -1), at_height(whole, -1), atol=1e-12)
        assert rays.share[0] == pytest.approx(whole.share[0], rel=1e-12)
        np.testing.assert_allclose(rays.colour, whole.colour, rtol=1e-12)
        assert (rays.astray == 0).all() and (rays.state == 0).all()


def test_glass_of_two_tints_on_one_body_is_one_medium():
    """A prism of which one face is tinted: what goes in by the clear one comes out by the other."""
    whole = prism(1.0)
    red = Glass(1.5, transmits=np.array([1.0, 0.5, 0.5]))
    right = whole.normals[whole.normal_triangles[:, 0], 0] > 0.1
    parts = [replace(whole, triangles=whole.triangles[~right], normal_triangles=whole.normal_triangles[~right])]
    parts += [
        replace(whole, triangles=whole.triangles[right], normal_triangles=whole.normal_triangles[right], material=red)
    ]
    rays, _ = follow(scene(*parts), [(-1, 0, -0.6)], [(1, 0, 0.2)], 0b111)
    plain, _ = follow(scene(whole), [(-1, 0, -0.6)], [(1, 0, 0.2)], 0b111)
    np.testing.assert_allclose(rays.direction, plain.direction, atol=1e-12)
    np.testing.assert_allclose(np.sort(rays.colour[:, 0]), [0.5, 1.0])
    assert (rays.astray == 0).all()


@pytest.mark.parametrize("order", [1, -1])
def test_what_lies_inside_displaces_what_is_round_it_in_any_order(order):
    """A ball of air in a block of glass, whichever is listed first."""
    block, hole = slab((-9, -9, -3), (9, 9, 3)), ball(fine=128, material=Glass(1.0))
    rays, _ = follow(scene(*(block, hole)[::order]), [(0.5, 0, 9)], [(0, 0, -1)], word=0b11111)
    t = np.arcsin(0.5 * 1.5)
    assert rays.direction[0, 0] == pytest.approx(1.5 * np.sin(2 * (t - np.arcsin(0.5))), abs=4e-3)


def test_glass_in_liquid_in_the_same_glass():
    """Three balls: the innermost is glass though the liquid is deeper in than the glass round it."""
    balls = [ball(r, fine=24, material=Glass(eta), name=f"Ball {r}") for r, eta in ((1, 1.5), (2, 1.33), (3, 1.5))]
    for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0)):
        media = Media(scene(*(balls[k] for k in order)))
        found = [media.eta[media.filling(np.array([media.at(np.array([0.1, 0.2, z]))]))][0] for z in (0, 1.5, 2.5, 4)]
        assert found == [1.5, 1.33, 1.5, 1.0]


def test_a_cavity_holds_air_whether_it_is_the_same_mesh_or_another():
    """A shell of 1 to 2: light through its middle passes four surfaces, and the ball within bends it as air does."""
    outer, inner = ball(2.0, fine=64), inside_out(ball(1.0, fine=64, name="Inner"))
    ways = []
    for parts in ((joined(outer, inner),), (outer, inner), (outer, ball(1.0, fine=64, material=Glass(1.0)))):
        rays, _ = follow(scene(*parts), [(0.3, 0, 9)], [(0, 0, -1)], word=0b11111)
        assert (rays.astray == 0).all() and (rays.state == 0).all()
        ways.append(np.concatenate([rays.direction[:, 0], at_height(rays, -5)[:, 0]]))
    np.testing.assert_allclose(ways[1:], ways[:1] * 2, atol=1e-9)
    inside = np.arcsin(0.3)  # n r sin is the same in every shell: 0.3 at the inner sphere from within, b / r
    turn = 2 * (np.arcsin(0.3 / 2) - np.arcsin(0.3 / 3) + np.arcsin(0.3 / 1.5) - inside)
    assert ways[0][0] == pytest.approx(-np.sin(turn), abs=4e-3)


def test_water_wound_downwards_is_water_all_the_same():
    still = water(flat, quads=2, side=40, level=5.0)
    for over in (still, inside_out(still)):
        rays, _ = follow(scene(ball(fine=128), over=over), [(0.5, 0, 9)], [(0, 0, -1)], word=0b1111)
        np.testing.assert_allclose(at_height(rays, -1.7)[0], through_a_ball(0.5, 1.5 / 1.333, -1.7), atol=2e-3)


def test_bubbles_under_water_spread_light():
    """A ball of air: glass of index 1, in the water."""
    where = scene(ball(fine=128, material=Glass(1.0)), over=water(flat, quads=2, side=40, level=5.0))
    b = np.array([0.2, 0.5, 0.7])
    rays, _ = follow(where, [(x, 0, 9) for x in b], [(0, 0, -1)] * 3, word=0b1111)
    np.testing.assert_allclose(at_height(rays, -1.7)[0], through_a_ball(b, 1 / 1.333, -1.7), rtol=2e-3)
    rays, _ = follow(where, [(0.9, 0, 9)], [(0, 0, -1)], word=0b110)
    assert rays.share[0] == pytest.approx(1 - (0.333 / 2.333) ** 2), "turned back whole beyond the critical angle"
    assert (rays.astray == 0).all()


@pytest.mark.parametrize("point, eta", [((0, 0, 0), 1.5), ((0.3, 0.1, 0.8), 1.5), ((0, 0, 1.5), 1.333), ((0, 0, 6), 1)])
def test_lamps_begin_in_what_is_round_them(point, eta):
    media = Media(scene(ball(fine=24), over=water(flat, quads=2, side=40, level=5.0)))
    assert media.eta[media.filling(np.array([media.at(np.array(point, float))]))][0] == eta
    assert media.at(np.array([0.0, 0.0, 7.0])) == 0


def baked(where, side=16, **settings):
    texels = [rasterise(r, side, padding=0) for r in where.receivers]
    return solve(where, texels, Settings(resolution=side, **settings)), texels


def test_a_lamp_in_the_middle_of_a_ball_shines_as_without_it():
    """Light along the radii: what a surface turns back leaves on the other side, so that the sum over all orders is
    cos / r^2 on the walls, times the glass's own absorption along 1, 3, 5 ... radii."""
    sigma = np.array([0.0, 0.2, 0.5])
    lamp = Point("Lamp", np.zeros(3), np.ones(3))
    around = ball(0.5, fine=96, material=Glass(1.5, sigma))
    answer, texels = baked(Scene(no_water(), room(1.0), (), (lamp,), casters=(around,)), tolerance=1e-5)
    clear = np.exp(-0.5 * sigma) * 0.96 / (1 - 0.04 * np.exp(-sigma))
    for image, own in zip(answer.images, texels, strict=True):
        expected = clear / (np.linalg.norm(own.positions, axis=1) ** 3)[:, None]
        np.testing.assert_allclose(image.reshape(-1, 3)[own.texel], expected, rtol=0.02)
    assert not any("went in" in sentence for sentence in answer.diagnostics.left_out)


def test_a_lamp_under_water_meets_glass_from_the_water():
    """Through a plate above a bed, on the axis: the k-th order of reflections comes from as deep as it goes in the
    plate, shortened by the ratio of the indices."""
    plate = slab((-1.5, -1.5, 0.5), (1.5, 1.5, 0.8))
    lamp = Point("Lamp", np.array([0.0, 0.0, 1.5]), np.ones(3))
    where = Scene(water(flat, quads=4, side=1.0, level=3.0), (floor(side=0.4),), (), (lamp,), casters=(plate,))
    texels = [rasterise(where.receivers[0], 8, padding=0)]
    (cast,) = over_casters(where, texels, Settings(resolution=8, tolerance=1e-3, bounces=4))
    light = (cast.spread()[0][:, 0] / texels[0].area).reshape(8, 8)
    ratio = 1.333 / 1.5
    f = ((1 - ratio) / (1 + ratio)) ** 2
    expected = sum((1 - f) ** 2 * f ** (2 * k) / (1.2 + (2 * k + 1) * 0.3 * ratio) ** 2 for k in range(3))
    # What the water's surface turns back, 1.5 m above, comes through the plate too: 2 % from 4.2 m away.
    w = (0.333 / 2.333) ** 2
    expected += w * (1 - f) ** 2 / (4.2 + 0.3 * ratio) ** 2
    assert light[3:5, 3:5].mean() == pytest.approx(expected, rel=3e-3)


def test_more_glasses_than_a_mask_holds():
    many = [slab((k, 0, 0), (k + 2, 1, 1), Glass(1.3 + k / 1000)) for k in range(54)]
    with pytest.raises(ValueError, match="at most 52 different glasses"):
        Media(scene(*many))
    apart = Media(scene(*(slab((k, 0, 0), (k + 0.5, 1, 1), Glass(1.3 + k % 2 / 10)) for k in range(200))))
    assert len(apart.eta) == 3 and apart.classes.max() == 1
    assert Media(scene(ball(material=SILVER))).classes[0] == -1
