"""The sun's disc over casters, against the closed form of a mirror's blurred edge."""

from dataclasses import replace

import numpy as np
import pytest
from casters import SILVER, ball, no_water, slab
from waves import floor, quad, sun

from dapple.kernels.disc.disc import rings_within, within_disc
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.optics import sun_frame
from dapple.kernels.scene import Scene, Settings, Sun
from dapple.kernels.trace.sun_disc import directions


def scene(angle):
    """A mirror 1 m wide that throws the light of a sun at 45 degrees onto a wall 2 m behind its middle."""
    light = Sun("Sun", np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)]), np.ones(3), angle)
    wall = quad("Wall", np.array([[3, -1.5, 0], [3, 1.5, 0], [3, 1.5, 3], [3, -1.5, 3]], float)[::-1])
    mirror = slab((0.5, -0.5, -0.1), (1.5, 0.5, 0.0), SILVER)
    return Scene(no_water(), (wall,), (), (light,), casters=(mirror,))


@pytest.mark.parametrize("points", [False, True])
def test_an_edge_is_as_blurred_as_the_disc_is_wide(points):
    """A uniform disc of radius r blurs each way by the standard deviation r / 2."""
    lit = scene(0.04)
    own = rasterise(lit.receivers[0], 48)
    answer = solve(lit, [own], Settings(resolution=48, points=points, tolerance=0.003 if points else 1e-4))
    image = answer.images[0][..., 0]
    side = own.positions[:, 1].reshape(48, 48)
    flux = image * 9 / 48**2
    assert flux.sum() == pytest.approx(np.sqrt(0.5), rel=1e-2)
    spread = (flux * side**2).sum() / flux.sum()
    way = 2 * np.sqrt(2)  # from the middle of the mirror
    assert spread == pytest.approx(1 / 12 + (way * np.tan(0.02)) ** 2 / 4, rel=1e-2)


def test_as_many_directions_as_can_be_seen():
    lit = scene(0.04)
    few, many = (rasterise(lit.receivers[0], side) for side in (8, 128))
    assert directions(lit, scene(0.0).lights[0], [many], 1e-2) == (1, 1)
    assert directions(lit, scene(0.001).lights[0], [few], 1e-2) == (1, 1)
    used, enough = directions(lit, lit.lights[0], [many], 1e-2)
    assert used == 16 and enough > 16
    thin, tolerances = scene(0.01), (0.1, 1e-2, 1e-3)
    counts = [directions(thin, thin.lights[0], [many], tolerance)[0] for tolerance in tolerances]
    assert counts[0] == 1 and counts == sorted(counts) and counts[1] % 4 == counts[2] % 4 == 0


def test_fours_have_the_moments_of_the_disc():
    light = Sun("Sun", np.array([0.6, 0.0, -0.8]), np.ones(3), 0.02)
    frame = sun_frame(light.direction)
    for count in (4, 8, 16):
        at = np.array([one.direction for one in rings_within(light, count)]) @ frame.T
        at = at[:, :2] / np.abs(at[:, 2:]) / np.tan(0.01)
        np.testing.assert_allclose(at.mean(0), 0, atol=1e-12)
        np.testing.assert_allclose(at.T @ at / count, np.eye(2) / 4, atol=1e-12)
        np.testing.assert_allclose((at**3).mean(0), 0, atol=1e-12)


def test_fours_make_a_focus_as_soft_as_many_suns_do():
    light = replace(sun((0.3, 0.2, -1)), angle=0.1)
    lit = Scene(no_water(), (floor(side=0.8),), (), (light,), casters=(ball(0.2, (0, 0, 0.3), fine=48),))
    own = [rasterise(lit.receivers[0], 24)]
    settings = Settings(resolution=24, tolerance=1e-2)
    suns = within_disc(light, 60, np.random.default_rng(3))
    suns = tuple(replace(one, name=str(k), irradiance=one.irradiance / 60) for k, one in enumerate(suns))
    expected = solve(replace(lit, lights=suns), own, settings).images[0]

    def error(light):
        found = solve(replace(lit, lights=(light,)), own, settings).images[0]
        return ((found - expected) ** 2).sum() / (expected**2).sum()

    assert error(light) < 1e-2 < error(replace(light, angle=0.0))
