"""What no scene can be is refused by name; what is only odd is solved."""

from dataclasses import replace

import numpy as np
import pytest
from waves import floor, sun, water

from dapple.kernels.casters import Caster, Glass, Volume
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, solve
from dapple.kernels.scene import Point, Scene, Settings

SETTINGS = Settings(tolerance=0.1, surface="mesh")


def pond(**changes):
    return replace(Scene(water(quads=8), (floor(),), (), (sun(),)), **changes)


def answer(scene, settings=SETTINGS):
    return solve(scene, [rasterise(receiver, 16) for receiver in scene.receivers], settings)


def ball(**material):
    """A box of glass in the water."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.2 + (0, 0, 0.7)
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])
    normals = (corners - (0, 0, 0.7)) / np.linalg.norm(corners - (0, 0, 0.7), axis=1)[:, None]
    return Caster("Ball", corners, triangles, normals, triangles, Glass(**{"eta": 1.5, **material}))


WRONG = [
    (lambda: pond(eta=np.nan), "eta must lie in"),
    (lambda: pond(eta=0.5), "eta must lie in"),
    (lambda: pond(sigma_a=np.array([0, 0, np.inf])), "sigma_a must lie in"),
    (lambda: pond(lights=(sun(irradiance=(1, -1, 1)),)), "irradiance of 'Sun' must lie in"),
    (lambda: pond(lights=(Point("Bulb", np.array([0, 0, np.nan]), np.ones(3)),)), "position of 'Bulb' must be finite"),
    (lambda: pond(casters=(ball(eta=np.inf),)), "eta of 'Ball' must lie in"),
    (lambda: pond(casters=(ball(transmits=np.full(3, 2.0)),)), "transmits of 'Ball' must lie in"),
    (lambda: pond(receivers=(floor(side=1e-8),)), "receiver 'Floor' span 1e-08 m under 4.8 m of water .*too small"),
    (lambda: pond(volume=Volume(np.diag([1.0, 0.0, 1.0, 1.0]))), "matrix of the volume must enclose something"),
    (lambda: pond(water=water(level=1e12)), "positions must lie within 1e\\+09 m of the origin"),
]


@pytest.mark.parametrize(("scene", "sentence"), WRONG)
def test_impossible_scenes_are_refused(scene, sentence):
    with pytest.raises(ValueError, match=sentence):
        answer(scene())


@pytest.mark.parametrize(("name", "value"), [("tolerance", 0.0), ("tolerance", np.nan), ("bounces", 0)])
def test_impossible_settings_are_refused(name, value):
    with pytest.raises(ValueError, match=f"{name} must be"):
        answer(pond(), replace(SETTINGS, **{name: value}))


@pytest.mark.parametrize("words", [{"resolution": 0}, {"resolution": 8, "padding": -1}])
def test_maps_without_size_are_refused(words):
    with pytest.raises(ValueError, match="resolution must be 1 or more and padding 0 or more"):
        rasterise(floor(), **words)


@pytest.mark.parametrize("method", METHODS)
def test_no_light_is_dark(method):
    """Without a lamp, with glass in the water and without, as by night."""
    for casters in ((), (ball(),)):
        dark = answer(pond(lights=(), casters=casters), replace(SETTINGS, method=method))
        assert not dark.images[0].any()


@pytest.mark.parametrize("method", METHODS)
def test_water_that_is_a_line_sheds_no_light(method):
    line = water(quads=4)
    line = replace(line, positions=line.positions * (1, 0, 1))
    assert np.isfinite(answer(pond(water=line), replace(SETTINGS, method=method)).images[0]).all()


def test_a_small_receiver_far_below_wide_water_takes_its_light():
    """A floor of 4 mm under 4.8 m: beams are split round it, not all over the water; and the sun's disc is many times
    as wide as its map."""
    lamp = replace(sun((0.0, 0.0, -1.0)), angle=0.0093)
    still = water(lambda x, y: (0 * x, 0 * x, 0 * x), quads=8)
    work = answer(Scene(still, (floor(side=4e-3),), (), (lamp,)))
    assert work.images[0].mean() == pytest.approx(1 - ((1.333 - 1) / (1.333 + 1)) ** 2, rel=0.02)
