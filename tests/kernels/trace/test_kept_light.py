"""What lights bring over casters, kept from frame to frame: the same light bit for bit, and no ray more than a change
asks for."""

from dataclasses import replace

import numpy as np
import pytest
from casters import SILVER, ball, no_water, slab
from waves import five_sines, floor, pool, sun, water

from dapple.kernels import methods
from dapple.kernels.anchor import Anchor, Kept
from dapple.kernels.casters import Glass
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Occluder, Point, Scene, Settings, Spot
from dapple.kernels.trace import kept_light
from dapple.kernels.trace.follow import Follower

SETTINGS = Settings(tolerance=0.5, resolution=24, surface="mesh", method="photon_splat")
SUN = sun((0.3, 0.1, -1))
LAMP = Point("Lamp", np.array([0.2, -0.3, 1.5]), np.array([1.0, 0.6, 0.2]))
SPOT = Spot("Spot", np.array([-0.3, 0.2, 1.2]), np.array([2.0, 2.0, 1.5]), half_angle=0.3)


def scene(lights=(SUN, LAMP)):
    casters = ball(0.15, (-0.2, 0, 0.2), fine=16), ball(0.1, (0.25, 0.1, 0.1), 12, material=SILVER, name="Mirror")
    return Scene(no_water(), (floor(side=1.0),), (), lights, casters=casters)


def moved(mesh, by=0.05):
    return replace(mesh, positions=mesh.positions + np.array([by, 0, 0]))


def with_caster(frame, **changes):
    return replace(frame, casters=(replace(frame.casters[0], **changes), *frame.casters[1:]))


def coloured(light, by):
    name = "irradiance" if light is SUN else "intensity"
    return replace(light, **{name: getattr(light, name) * np.asarray(by)})


def in_pool(number):
    """Waves of a frame, and a block of glass that hangs over them from the rim."""
    glass = slab((0.3, 0.2, 1.2), (0.9, 0.8, 1.7))
    waves = water(lambda x, y: five_sines(x, y, number / 2), 12, side=2.4)
    return replace(pool(quads=4), water=waves, casters=(glass,))


BASE = scene()
FRAMES = {
    "one of the casters moves": [
        replace(BASE, casters=(BASE.casters[0], moved(BASE.casters[1], k / 20))) for k in range(3)
    ],
    "a receiver moves": [replace(BASE, receivers=(moved(BASE.receivers[0], k / 20),)) for k in range(2)],
    "the water moves beside glass": [in_pool(k) for k in (1, 2)],
    "one of the lights moves": [scene((SUN, replace(LAMP, position=np.array([0.2, k / 10, 1.5])))) for k in range(3)],
    "a light turns": [scene((sun((0.3, k / 10, -1)), SPOT)) for k in range(2)],
    "strengths and colours": [scene((coloured(SUN, 1 + k), coloured(LAMP, [1, 1 + k, 1]))) for k in range(3)],
    "a channel goes dark": [scene((coloured(SUN, [1, 1, k]), coloured(LAMP, [1, 1, 0]))) for k in (1, 0)],
    "a light is put on and out": [scene((SUN,)), BASE, scene((LAMP,)), BASE],
    "nothing in it": [BASE, scene()],
    "another topology": [BASE, replace(BASE, casters=(ball(0.15, (-0.2, 0, 0.2), fine=14), BASE.casters[1]))],
    "another glass": [BASE, with_caster(BASE, material=Glass(1.7))],
    "something comes into the light and leaves it": [
        replace(BASE, occluders=(Occluder("Board", moved(floor(side=0.4, z=0.6), x).positions, floor().triangles),))
        for x in (5.0, 0.2, -5.0)
    ],
    "a disc": [scene((replace(SUN, angle=0.05 if k < 2 else 0.04), coloured(LAMP, 1 + k))) for k in range(3)],
    "dispersion": [with_caster(scene((SUN, coloured(LAMP, 1 + k))), material=Glass(1.5, abbe=30.0)) for k in range(2)],
}


def solved(frame, kept, settings=SETTINGS):
    texels = tuple(rasterise(r, settings.resolution) for r in frame.receivers)
    return methods.solve(frame, texels, settings, kept)


@pytest.mark.parametrize("frames", FRAMES.values(), ids=FRAMES)
def test_frames_are_the_same_bit_for_bit_in_any_order(frames):
    alone = [solved(frame, Kept(Anchor())) for frame in frames]
    kept = Kept(Anchor())
    for k in (*range(len(frames)), *reversed(range(len(frames)))):
        answer = solved(frames[k], kept)
        for image, expected in zip(answer.images, alone[k].images, strict=True):
            assert image.any() and (image == expected).all()
        work, expected = answer.diagnostics, alone[k].diagnostics
        assert work.left_out == expected.left_out and work.estimated_error == expected.estimated_error
        np.testing.assert_array_equal(work.flux_in, expected.flux_in)
        assert work.flux_lost.keys() == expected.flux_lost.keys()
        for cause, watts in work.flux_lost.items():
            np.testing.assert_array_equal(watts, expected.flux_lost[cause])


@pytest.fixture
def rays(monkeypatch):
    """A function of a frame, a Kept and Settings: how many rays it casts over casters to solve it."""
    followers, made = [], Follower.__init__

    def make(self, *arguments):
        made(self, *arguments)
        followers.append(self)

    def cast(frame, kept, settings=SETTINGS):
        followers.clear()
        solved(frame, kept, settings)
        return sum(follower.cast for follower in followers)

    monkeypatch.setattr(Follower, "__init__", make)
    return cast


def test_a_lamp_of_another_colour_costs_no_ray(rays):
    kept = Kept(Anchor())
    assert rays(scene(), kept) > 1000
    for frame in FRAMES["strengths and colours"]:
        assert rays(frame, kept) == 0


def test_only_the_light_that_moves_is_followed(rays):
    kept, frames = Kept(Anchor()), FRAMES["one of the lights moves"]
    rays(frames[0], kept)
    own = [rays(scene(frame.lights[1:]), Kept(Anchor())) for frame in frames]
    assert [rays(frame, kept) for frame in frames[1:]] == own[1:]


def test_less_is_followed_where_one_of_what_it_meets_is_another(rays):
    kept, frames = Kept(Anchor()), FRAMES["another topology"]
    rays(frames[0], kept)
    assert 1000 < rays(frames[1], kept) < 0.95 * rays(frames[1], Kept(Anchor()))


@pytest.mark.parametrize("name", ["a receiver moves", "another glass"])
def test_all_is_followed_where_what_it_meets_is_another(rays, name):
    kept, frames = Kept(Anchor()), FRAMES[name]
    rays(frames[0], kept)
    assert rays(frames[1], kept) == rays(frames[1], Kept(Anchor())) > 1000


def test_rough_passes_do_not_put_out_what_is_kept(rays):
    kept, rough = Kept(Anchor()), replace(SETTINGS, tolerance=1.0)
    assert rays(BASE, kept, rough) > 0 and rays(BASE, kept) > 0
    assert rays(BASE, kept, rough) == rays(BASE, kept) == 0


def test_what_is_kept_is_bounded(monkeypatch):
    """Of three lights in turn, where two have room, the first is gone before it comes again."""
    monkeypatch.setattr(kept_light, "_MOST", 100)
    kept, lit, followed = Kept(Anchor()).light, np.ones(3, bool), []

    def ask(name):
        def follow():
            followed.append(name)
            return np.zeros((1, 6)), {}, 1.0, 0.0, None

        kept.of(BASE, replace(LAMP, name=name), lit, (), SETTINGS, follow)

    for name in "abab" + "cabc" + "bb":
        ask(name)
    assert "".join(followed) == "abcabc"
