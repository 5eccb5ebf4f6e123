"""Single rays over glass, mirrors and water, against the closed forms of geometric optics."""

import numpy as np
import pytest
from caster_rays import at_height, follow, scene, through_a_ball
from casters import SILVER, ball, faceted, patch, prism, slab
from waves import flat, water

from dapple.kernels.casters import Glass, Mirror, Volume
from dapple.kernels.rays import MISS
from dapple.kernels.trace.codes import Codes
from dapple.kernels.trace.follow import BEYOND, BLOCKED, CULLED, Follower, Rays
from dapple.kernels.trace.surfaces import Surfaces
from dapple.kernels.trace.volume import Box


@pytest.mark.parametrize("angle", [10.0, 40.0, 75.0])
def test_a_slab_moves_light_aside(angle):
    """h sin a (1 - cos a / sqrt(n^2 - sin^2 a)), and not its direction."""
    a = np.radians(angle)
    where = scene(slab((-9, -9, 0), (9, 9, 0.7)))
    rays, _ = follow(where, [(0, 0.1, 1.0)], [(np.sin(a), 0, -np.cos(a))], word=0b111)
    np.testing.assert_allclose(rays.direction[:, 0], [np.sin(a), 0, -np.cos(a)], atol=1e-12)
    straight = 2 * np.tan(a)
    moved = (straight - at_height(rays, -1.0)[0, 0]) * np.cos(a)
    assert moved == pytest.approx(0.7 * np.sin(a) * (1 - np.cos(a) / np.sqrt(1.5**2 - np.sin(a) ** 2)), abs=1e-12)


@pytest.mark.parametrize("eta", [1.49, 1.50, 1.52])
def test_a_prism_turns_light_by_the_closed_form(eta):
    """D = i + e - A, with sin e = sin A sqrt(n^2 - sin^2 i) - cos A sin i; so each colour has its own."""
    apex, i = np.radians(50.0), np.radians(40.0)
    where = scene(prism(apex, material=Glass(eta)))
    n = np.array([-np.cos(apex / 2), 0, np.sin(apex / 2)])
    along = np.array([np.sin(apex / 2), 0, np.cos(apex / 2)])
    d = -np.cos(i) * n + np.sin(i) * along
    middle = np.array([-np.sin(apex / 2), 0, -np.cos(apex / 2)]) / 2
    rays, _ = follow(where, [middle - d], [d], word=0b111)
    e = np.arcsin(np.sin(apex) * np.sqrt(eta**2 - np.sin(i) ** 2) - np.cos(apex) * np.sin(i))
    turned = np.arccos(d @ rays.direction[:, 0])
    assert turned == pytest.approx(i + e - apex, abs=1e-12)


def test_a_right_angle_turns_all_light_back():
    """Light through the short side of a half cube meets the long side at 45 degrees, beyond the critical 41.8."""
    corners = [(x, y, z) for y in (-1, 1) for x, z in ((0, 0), (1, 0), (0, 1))]
    half = faceted(corners, [(0, 1, 2), (3, 5, 4), (0, 2, 5, 3), (0, 3, 4, 1), (1, 4, 5, 2)])
    rays, end = follow(scene(half), [(0.3, 0, -1)], [(0, 0, 1)], word=0b1101)
    assert rays.share[0] == pytest.approx((1 - 0.04) ** 2, rel=1e-9) and end[0] == MISS
    np.testing.assert_allclose(rays.direction[:, 0], [-1, 0, 0], atol=1e-12)
    assert not len(list(Follower(Surfaces(scene(half), np.ones(3)), 6).ends(Rays.of(*_ray(), 1), Codes([0b111]))))


def _ray():
    return np.array([[0.3], [0.0], [-1.0]]), np.array([[0.0], [0.0], [1.0]])


def test_a_ball_focuses_by_the_closed_form():
    """The full caustic: landing radius against impact parameter, spherical aberration and all."""
    b = np.array([0.05, 0.2, 0.4, 0.6, 0.8, 0.9])
    where = scene(ball(fine=256))
    rays, _ = follow(where, [(x * 0.6, x * 0.8, 3) for x in b], [(0, 0, -1)] * len(b), word=0b111)
    radius = [0.6, 0.8] @ at_height(rays, -1.7)
    np.testing.assert_allclose(radius, through_a_ball(b, 1.5, -1.7), atol=1e-3)


def test_a_balls_paraxial_focus():
    """n R / (2 (n - 1)) behind the centre."""
    b = np.array([0.05, 0.1])
    rays, _ = follow(scene(ball(fine=200)), [(x, 0, 3) for x in b], [(0, 0, -1)] * 2, word=0b111)
    crossing = rays.origin[2] - rays.origin[0] / rays.direction[0] * rays.direction[2]
    np.testing.assert_allclose(crossing, -1.5 / (2 * 0.5), rtol=6e-3)


def test_glass_under_water_bends_by_the_ratio_of_the_indices():
    b = np.array([0.2, 0.5, 0.8])
    where = scene(ball(fine=256), over=water(flat, quads=2, side=40, level=5.0))
    rays, _ = follow(where, [(x, 0, 9) for x in b], [(0, 0, -1)] * len(b), word=0b1111)
    np.testing.assert_allclose(at_height(rays, -1.7)[0], through_a_ball(b, 1.5 / 1.333, -1.7), atol=1e-3)
    assert (rays.state == 1).all(), "they end in the water"


def test_a_ball_of_the_waters_index_is_no_ball():
    where = scene(ball(material=Glass(1.333)), over=water(flat, quads=2, side=40, level=5.0))
    rays, _ = follow(where, [(-0.5, 0.4, 9)], [(0.1, 0, -1)])
    assert len(rays.photon) == 1, "nothing is turned back"
    start = np.sin(np.arctan(0.1)) / 1.333
    np.testing.assert_allclose(rays.direction[:, 0], [start, 0, -np.sqrt(1 - start**2)], atol=1e-9)


@pytest.mark.parametrize("axis", [(0, 0, -1), (0.3, -0.2, -1)])
def test_shares_of_all_branches_make_one_photon(axis):
    where = scene(ball(fine=32), slab((-1, -1, -3), (1, 1, -2)))
    rng = np.random.default_rng(0)
    origins = np.column_stack([rng.uniform(-0.5, 0.5, (40, 2)), np.full(40, 4.0)])
    rays, _ = follow(where, origins - 4 * np.array([*axis[:2], 0]), [axis] * 40)
    shares = np.bincount(rays.photon, rays.share)
    np.testing.assert_allclose(shares, 1, atol=1e-12)
    assert len(rays.photon) > 300


def test_light_that_no_code_asks_for_is_in_no_other():
    """The codes of all branches, followed one by one, bring what full branching brings, once each."""
    where = scene(ball(fine=32))
    origins, directions = [(0.3, 0.2, 4)] * 1, [(0, 0, -1)]
    rays, end = follow(where, origins, directions, bounces=4)
    landed = end >= 0
    assert len(set(rays.code)) == len(rays.code) and landed.sum() >= 2
    for k in np.flatnonzero(landed):
        one, _ = follow(where, origins, directions, word=rays.code[k], bounces=4)
        assert one.share[0] == rays.share[k]
        np.testing.assert_array_equal(one.direction[:, 0], rays.direction[:, k])


def test_a_parabola_has_one_focus():
    def point(u, v):
        return u, v, (u**2 + v**2) / 8  # focal length 2

    def normal(u, v):
        length = np.sqrt(1 + (u**2 + v**2) / 16)
        return -u / 4 / length, -v / 4 / length, 1 / length

    side = np.linspace(-1, 1, 201)
    where = scene(patch(point, normal, side, side, SILVER))
    x = np.array([(0.9, 0.1), (-0.3, 0.7), (0.05, -0.01), (0.5, 0.5)])
    rays, _ = follow(where, np.column_stack([x, np.full(4, 9.0)]), [(0, 0, -1)] * 4)
    np.testing.assert_allclose(at_height(rays, 2.0), 0, atol=1e-4)
    assert (rays.share == 1).all() and (rays.colour == 1).all()


def test_glass_absorbs_along_the_true_path_and_tints():
    """Beer-Lambert over h / cos t, and the colour of each of two crossings."""
    material = Glass(1.5, np.array([0.0, 1.0, 2.0]), transmits=np.array([1.0, 0.5, 1.0]))
    rays, _ = follow(scene(slab((-9, -9, 0), (9, 9, 0.7), material)), [(0, 0.1, 1)], [(1, 0, -1)], word=0b111)
    length = 0.7 / np.sqrt(1 - 0.5 / 1.5**2)
    expected = np.exp(-np.array([0.0, 1.0, 2.0]) * length) * [1, 0.25, 1]
    np.testing.assert_allclose(np.sort(rays.colour[:, 0]), np.sort(expected), rtol=1e-12)


def test_mirrors_multiply_their_colours():
    red = Mirror(np.array([0.8, 0.2, 0.2]), np.ones(3))
    corner = [patch(lambda u, v: (u, v, 0 * u), lambda u, v: (0 * u, 0 * u, 1 + 0 * u), *_SPAN, red, "Floor")]
    corner.append(patch(lambda u, v: (0 * u, u, v), lambda u, v: (1 + 0 * u, 0 * u, 0 * u), *_SPAN, red, "Wall"))
    rays, end = follow(scene(*corner), [(0.5, 0, 1.0)], [(-1, 0, -1)])
    expected = np.array([0.8, 0.2]) + np.array([0.2, 0.8]) * (1 - np.sqrt(0.5)) ** 5
    np.testing.assert_allclose(np.sort(rays.colour[:, 0]), np.sort(expected**2), rtol=1e-9)
    np.testing.assert_allclose(rays.direction[:, 0], np.array([1, 0, 1]) / np.sqrt(2), atol=1e-12)
    assert end[0] == MISS


_SPAN = np.linspace(-2, 2, 5), np.linspace(-2, 2, 5)


def test_more_meetings_than_bounces_are_not_followed():
    rays, end = follow(scene(ball(fine=64)), [(0.2, 0, 4)], [(0, 0, -1)], bounces=3, faint=0.0)
    assert set(end[end < -1]) == {BEYOND}
    assert np.bincount(rays.photon, rays.share)[0] == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("bounces", [1, 2, 3, 4])
def test_as_many_surfaces_are_met_as_bounces_say(bounces):
    """Down through two plates, which takes four."""
    where = scene(slab((-9, -9, 1), (9, 9, 2)), slab((-9, -9, -2), (9, 9, -1)))
    rays, end = follow(where, [(0.1, 0.2, 9)], [(0, 0, -1)], bounces=bounces)
    straight = (rays.code == 0b11111) & (end >= 0)
    assert np.count_nonzero(straight) == (bounces == 4)
    assert rays.met.max() == bounces and (rays.met[end == BEYOND] == bounces).all()


def test_a_volume_ends_light_at_its_culling_faces_and_casters_outside_are_opaque():
    matrix = np.diag([2.0, 2.0, 2.0, 1.0])
    where = scene(slab((-1, -1, -0.5), (1, 1, 0.5)), slab((-1, -1, -2.5), (1, 1, -2.1), name="Below"))
    straight, down = [(0.1, 0.2, 9)], [(0, 0, -1)]
    _, end = follow(where, straight, down, word=0b111, box=Box(Volume(matrix)))
    assert list(end) == [BLOCKED]
    culled = Volume(matrix, (False,) * 4 + (True, False))
    _, end = follow(where, straight, down, word=0b111, box=Box(culled))
    assert list(end) == [CULLED]
    _, end = follow(where, straight, down, word=0b11111)
    assert 0 <= end[0] < 2, "without a volume it goes through both to the floor"


def test_glass_within_glass_takes_its_place():
    """A ball of air is not a material, but one of index 1 is: light bends at it, and again as it leaves it."""
    where = scene(slab((-9, -9, -3), (9, 9, 3)), ball(fine=256, material=Glass(1.0)))
    rays, _ = follow(where, [(0.5, 0, 9)], [(0, 0, -1)], word=0b11111)
    i = np.arcsin(0.5)
    t = np.arcsin(0.5 * 1.5)
    leaves = (np.pi / 2 - i) - (np.pi - 2 * t)
    inside = np.cos(leaves) - np.tan(2 * (i - t)) * (np.sin(leaves) + 3)
    assert rays.origin[0, 0] == pytest.approx(inside, abs=2e-3)
    assert rays.direction[0, 0] == pytest.approx(1.5 * np.sin(2 * (t - i)), abs=2e-3)
