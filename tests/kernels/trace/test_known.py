"""Ways that are kept from frame to frame: the light is the same bit for bit, and few rays are cast again."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball, no_water, patch
from waves import five_sines, floor, pool, quad, sun, water

from dapple.kernels.anchor import Anchor, Kept
from dapple.kernels.casters import Glass, Volume
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Point, Scene, Settings
from dapple.kernels.trace import kept_light
from dapple.kernels.trace.follow import Follower

SIDE = 24


def ring(material=None):
    """A glass ring that stands still."""

    def normal(u, v):
        return np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)

    def point(u, v):
        out = 0.5 + 0.15 * np.cos(v)
        return out * np.cos(u) - 0.8, out * np.sin(u), 0.15 * np.sin(v)

    whole = np.linspace(0, 2 * np.pi, 41), np.linspace(0, 2 * np.pi, 17)
    return patch(point, normal, *whole, material or Glass(1.5), "Ring")


def small(x=0.6, z=-0.2):
    """A small ball beside the ring."""
    return ball(0.15, (x, 0.2, z), fine=12, name="Small")


def lit(*casters, direction=(0.2, 0.1, -1), **others):
    given = {"receivers": (floor(side=4.0, z=-0.7),), "occluders": (), "lights": (sun(direction),), **others}
    return Scene(no_water(), casters=casters or (ring(), small()), **given)


class Frames:
    """Solves Scenes one after the other with what is kept, compares each with what it is alone, and counts rays."""

    def __init__(self, monkeypatch, **settings):
        self._settings = Settings("photon_splat", **{"tolerance": 0.1, "resolution": SIDE, "bounces": 4, **settings})
        self.kept, self._followers, begin = Kept(Anchor()), [], Follower.__init__

        def init(follower, *given):
            begin(follower, *given)
            self._followers.append(follower)

        monkeypatch.setattr(Follower, "__init__", init)

    def _solve(self, scene, kept=None):
        self._followers.clear()
        texels = tuple(rasterise(r, SIDE, padding=1) for r in scene.receivers)
        return solve(scene, texels, self._settings, kept), sum(follower.cast for follower in self._followers)

    def share(self, scene):
        """How many rays were cast of those that the frame needs alone."""
        (answer, cast), (alone, whole) = self._solve(scene, self.kept), self._solve(scene)
        for found, expected in zip(answer.images, alone.images, strict=True):
            np.testing.assert_array_equal(found, expected)
        work, books = answer.diagnostics, alone.diagnostics
        assert work.estimated_error == books.estimated_error and work.left_out == books.left_out
        assert work.flux_lost.keys() == books.flux_lost.keys()
        for cause, watts in books.flux_lost.items():
            np.testing.assert_array_equal(work.flux_lost[cause], watts)
        assert any(image.any() for image in alone.images) and whole > 10_000
        return cast / whole


@pytest.fixture
def frames(monkeypatch):
    return Frames(monkeypatch)


def card(x, y=0.0, z=-0.5):
    """A board between the ring and the floor."""
    corners = ((x - 0.3, y - 0.2, z), (x + 0.3, y - 0.2, z), (x + 0.3, y + 0.3, z), (x - 0.3, y + 0.3, z))
    board = quad("Card", corners)
    return Occluder("Card", board.positions, board.triangles)


def test_a_small_thing_that_moves_leaves_the_rest_as_it_is(frames):
    assert frames.share(lit()) == 1
    for x in (0.61, 0.63):
        assert frames.share(lit(ring(), small(x))) < 0.4


def test_a_thing_that_moves_far_off_costs_few_rays(frames):
    """Those of the first look, and those so near an edge that another search may find its other side."""
    assert frames.share(lit(occluders=(card(1.4, 1.4),))) == 1
    for x in (1.41, 1.42):
        assert frames.share(lit(occluders=(card(x, 1.4),))) < 0.3


def test_a_thing_comes_into_the_light_and_leaves_it(frames):
    """The small ball on its way through the ring."""
    assert frames.share(lit(ring(), small(0.7), small(0.3))) == 1
    for x in (-0.8, 0.3):
        assert 0.2 < frames.share(lit(ring(), small(0.7), small(x))) < 0.95


def test_a_card_comes_between_the_ring_and_the_floor_and_leaves(frames):
    assert frames.share(lit(occluders=(card(-0.6, 1.5),))) == 1
    for y in (0.0, 1.5):
        assert 0.3 < frames.share(lit(occluders=(card(-0.6, y),))) < 0.95


def test_what_moves_beyond_all_that_light_meets_is_a_change_to_all(frames):
    """So far off no way is known: it may stand between a lamp and the scene."""
    assert frames.share(lit(occluders=(card(400.0),))) == 1
    assert frames.share(lit(occluders=(card(401.0),))) == 1


def test_light_that_met_what_is_gone_goes_on(frames):
    """What one receiver took on its way to another."""
    under, plate = floor(side=4.0, z=-0.7), replace(floor(side=0.6, z=-0.4), name="Plate")
    here, away = (replace(plate, positions=plate.positions + np.array([x, 0, 0])) for x in (-0.7, 1.2))
    assert frames.share(lit(receivers=(under, here))) == 1
    assert 0.1 < frames.share(lit(receivers=(under, away))) < 1


def test_a_mesh_that_comes_or_goes_is_a_change_to_all(frames):
    assert frames.share(lit()) == 1
    assert frames.share(lit(ring(), small(), small(1.0))) == 1
    assert frames.share(lit()) == 1


def test_optics_lamps_and_the_volume_change_all(frames):
    frames.share(lit())
    box = Volume(np.diag([3.0, 3.0, 1.0, 1.0]))
    for scene in (
        lit(ring(Glass(1.6)), small()),
        lit(ring(Glass(1.6, np.array([0.0, 1.0, 2.0]))), small()),
        lit(direction=(0.25, 0.1, -1)),
        lit(volume=box),
        lit(volume=replace(box, matrix=np.diag([2.9, 3.0, 1.0, 1.0]))),
        lit(volume=replace(box, culling=(True,) * 6)),
    ):
        assert frames.share(scene) == 1


def test_another_topology_is_a_change_of_one_mesh(frames):
    frames.share(lit())
    assert frames.share(lit(ring(), ball(0.15, (0.6, 0.2, -0.2), fine=14, name="Small"))) < 0.4


def test_all_that_lands_on_a_receiver_that_moves_is_traced_again(frames):
    frames.share(lit())
    assert frames.share(lit(receivers=(floor(side=4.0, z=-0.701),))) > 0.5


def test_shading_is_a_change_though_nothing_moves(frames):
    frames.share(lit())
    leaning = small().normals + np.array([0.02, 0, 0])
    leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
    assert 0.02 < frames.share(lit(ring(), replace(small(), normals=leaning))) < 0.4


def test_a_thing_that_comes_near_another_counts_as_its_change(frames):
    """Light in a ball is sought in that alone, until something reaches into the box round it."""
    still = ball(0.3, (-0.8, 0, 0), fine=16, name="Still")
    where = [lit(still, small(x, z=0.1)) for x in (0.6, -0.45, -0.44, 0.6)]
    assert frames.share(where[0]) == 1
    for scene in where[1:]:
        assert 0.1 < frames.share(scene) <= 1


@pytest.mark.parametrize("way", ["lamp", "disc", "colours", "volume"])
def test_other_lights_and_scenes(monkeypatch, way):
    """A lamp, a sun with a disc, glass that bends colours apart, and a volume whose side ends light."""
    others, settings = {}, {}
    if way == "lamp":
        others["lights"] = (Point("Lamp", np.array([-0.5, 0.1, 1.5]), np.ones(3)),)
    elif way == "disc":
        others["lights"] = (replace(sun((0.2, 0.1, -1)), angle=0.1),)
    elif way == "colours":
        settings["dispersion"] = 30.0
    else:
        others["volume"] = Volume(np.diag([1.5, 1.5, 0.4, 1.0]), (True, False, False, False, False, False))
    frames = Frames(monkeypatch, tolerance=0.2, **settings)
    assert frames.share(lit(ring(), small(), **others)) == 1
    assert frames.share(lit(ring(), small(0.61), **others)) < 0.5


def test_still_glass_beside_water_that_moves(monkeypatch):
    frames = Frames(monkeypatch, surface="mesh", tolerance=0.2)
    glass = ball(0.2, (0.8, 0.2, 1.4), fine=16), ball(0.15, (-0.1, 0, 1.6), fine=16)
    waves = [water(lambda x, y, k=k: five_sines(x, y, k / 2), 12, side=1.0) for k in (1, 2, 3)]
    first, *rest = (replace(pool(quads=4), water=own, casters=glass) for own in waves)
    assert frames.share(first) == 1
    for scene in rest:
        assert 0.2 < frames.share(scene) < 0.9


def test_nothing_is_kept_where_all_moves(frames):
    """The ring alone, on its way, and a lamp: of the first frame alone a little is kept, in vain."""
    moved = [replace(ring(), positions=ring().positions + np.array([x, 0, 0])) for x in (0, 0.02, 0.04)]
    assert frames.share(lit(moved[0])) == 1
    assert frames.share(lit(moved[1])) > 0.9
    assert frames.share(lit(moved[2])) > 0.9 and size(frames) < 1e5
    for x in (0.2, 0.21, 0.22):
        assert frames.share(lit(direction=(x, 0.1, -1))) == 1 and size(frames) == 0


def size(frames):
    return sum(known.size() for known in frames.kept.light._ways.values())


def test_what_is_kept_is_bounded(monkeypatch):
    frames = Frames(monkeypatch)
    frames.share(lit())
    whole = size(frames)
    monkeypatch.setattr(kept_light, "_MOST_WAYS", whole // 2)
    frames = Frames(monkeypatch)
    frames.share(lit())
    assert 0.4 * whole < size(frames) < 0.9 * whole
    assert 0.2 < frames.share(lit(ring(), small(0.61))) < 0.95
