"""Light of several codes landed together: the same as rays say one by one, wherever they are asked for."""

import numpy as np
import pytest
from casters import ball, no_water
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Point, Scene, Settings, Spot
from dapple.kernels.splat.lander import OTHER, UNLIT
from dapple.kernels.trace.brightness import Brightness
from dapple.kernels.trace.cast import over_casters
from dapple.kernels.trace.code_lander import CodeLander
from dapple.kernels.trace.codes import Codes

WORDS = [0b111, 0b10, 0b1101]
LAMP = Point("Lamp", np.array([0.1, 0.2, 3.0]), np.ones(3))


def _cast(light):
    scene = Scene(no_water(), (floor(side=6.0),), (), (light,), casters=(ball(0.8, (0, 0, 1.2), fine=32),))
    texels = [rasterise(receiver, 32) for receiver in scene.receivers]
    return over_casters(scene, texels, Settings(resolution=32))[0]


def _asked(cast, count, seed=0):
    """Points of the entry, some of them twice or thrice, and numbers of codes that they ask for."""
    rng = np.random.default_rng(seed)
    m = cast.water.points[cast.water.triangles].mean(1).T
    m = m[:, rng.integers(0, m.shape[1], count)]
    return m, rng.integers(0, len(WORDS), count)


@pytest.mark.parametrize("light", [sun((0.2, 0.1, -1)), LAMP], ids=["sun", "lamp"])
def test_each_point_lands_as_its_ray_does_alone(light):
    cast = _cast(light)
    lander = CodeLander(cast, WORDS, Brightness(cast.texels))
    m, number = _asked(cast, 3000)
    nodes = lander.land(m, np.zeros((0, m.shape[1])), number)
    rays, met = cast.start(m)
    came, checked = np.zeros(m.shape[1], bool), 0
    for k, word in enumerate(WORDS):
        for ended, end in cast.follower.ends(rays, Codes([word])):
            landed = cast.landed(ended, end)
            mine = number[ended.photon] == k
            came[ended.photon[mine]] = True
            at = landed.photon[number[landed.photon] == k]
            own = number[landed.photon] == k
            np.testing.assert_allclose(nodes.x[at], landed.x[own], atol=1e-9)
            np.testing.assert_allclose(nodes.y[at], landed.y[own], atol=1e-9)
            share = (ended.share * met[ended.photon])[landed.ray]
            np.testing.assert_allclose(nodes.carried[0, at], (share * landed.colour[0])[own], rtol=1e-12)
            assert (lander.image[nodes.chart[at]] == 0).all()
            checked += len(at)
    assert checked > 600 and (nodes.chart[~came] == OTHER).all() and (nodes.carried[:, ~came] == 0).all()
    assert (nodes.spread == 1).all() == (light is not LAMP)


def test_points_that_are_asked_for_twice_are_traced_once():
    cast = _cast(sun((0, 0, -1)))
    lander = CodeLander(cast, WORDS, Brightness(cast.texels))
    m, number = _asked(cast, 500)
    lander.land(m, np.zeros((0, 500)), number)
    once = cast.follower.cast
    many = np.tile(m, 6), np.zeros((0, 3000)), np.tile(number, 6)
    nodes = lander.land(*many)
    assert cast.follower.cast == 2 * once
    np.testing.assert_array_equal(nodes.x.reshape(6, -1), np.tile(nodes.x[:500], (6, 1)))


def test_light_of_different_paths_is_on_different_sheets():
    """In one chart of the floor, light straight through and light that is turned back once inside."""
    cast = _cast(sun((0, 0, -1)))
    lander = CodeLander(cast, [0b111, 0b11001], Brightness(cast.texels))
    m, _ = _asked(cast, 2000)
    charts = [lander.land(m, np.zeros((0, 2000)), np.full(2000, k)).chart for k in (0, 1)]
    sheets = [set(chart[chart >= 0]) for chart in charts]
    assert len(sheets[0]) == len(sheets[1]) == 1 and not sheets[0] & sheets[1]


def test_no_points_are_no_nodes():
    cast = _cast(sun((0, 0, -1)))
    nodes = CodeLander(cast, WORDS, Brightness(cast.texels)).land(*np.zeros((2, 3, 0)), np.zeros(0, int))
    assert nodes.chart.shape == (0,) and nodes.carried.shape == (2, 0)


def test_parts_are_finer_where_the_tolerance_is_strict():
    cast = _cast(sun((0, 0, -1)))
    assert CodeLander(cast, WORDS, Brightness(cast.texels)).fine == 1.0
    cast.settings = Settings(tolerance=1e-4)
    assert CodeLander(cast, WORDS, Brightness(cast.texels)).fine == 0.5


def test_what_no_light_meets_is_unlit():
    spot = Spot("Spot", np.array([0.0, 0, 4.0]), np.ones(3), half_angle=0.1)
    cast = _cast(spot)
    m = np.array([[0.0, 1.0], [0.0, 0.0], [3.0, 3.0]])
    nodes = CodeLander(cast, WORDS, Brightness(cast.texels)).land(m, np.zeros((0, 2)), np.zeros(2, int))
    assert nodes.chart[1] == UNLIT and nodes.chart[0] >= 0
