"""Area lamps: flux and irradiance in closed form, over glass and over still water."""

import numpy as np
import pytest
from casters import ball, no_water, slab
from waves import flat, floor, transmitted, water

from dapple.kernels.area_lamps import Area, Patch, in_patches
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Scene, Settings

DOWN = np.diag([1.0, -1.0, -1.0])
SIDE = 24
HIGH, THICK = 4.0, 0.2


def lamp(width=0.0, **values):
    sides = width / 2 * np.array([[1.0, 0, 0], [0, 0.5, 0]])
    return Area("Lamp", np.array([0, 0, HIGH]), np.array([1.0, 0.5, 0.25]), frame=DOWN, sides=sides, **values)


def through_plate(points, out):
    """Irradiance on points (n,3) of z = 0 below a plate, of a flat lamp of 1 W/sr at a point (3,), over all orders."""
    rho = np.linalg.norm((points - out)[:, :2], axis=1)
    air, total = out[2] - THICK, 0.0
    for order in range(3):
        glass, low, high = THICK * (2 * order + 1), np.zeros(len(points)), np.full(len(points), 1 - 1e-9)
        for _ in range(50):
            sine = (low + high) / 2
            short = air * sine / np.sqrt(1 - sine**2) + glass * sine / np.sqrt(2.25 - sine**2) < rho
            low, high = np.where(short, sine, low), np.where(short, high, sine)
        cosine = np.sqrt(1 - sine**2)
        once = np.array([1 - transmitted(c, 1.5) for c in cosine])
        slope = air / cosine**3 + glass * 2.25 / (2.25 - sine**2) ** 1.5
        geometry = np.where(rho > 1e-6, sine / np.maximum(rho, 1e-12) / (slope * cosine), (air + glass / 1.5) ** -2)
        total = total + cosine * (1 - once) ** 2 * once ** (2 * order) * geometry
    return total


@pytest.mark.parametrize("width", [0.0, 1.2])
def test_through_a_plate_of_glass(width):
    """A lamp 1.2 by 0.6 m, and one without a size: texel by texel, colours apart, and their books."""
    plate = slab((-2, -2, 1.0), (2, 2, 1.0 + THICK))
    scene = Scene(no_water(), (floor(side=1.0),), (), (lamp(width),), casters=(plate,))
    (own,) = texels = [rasterise(scene.receivers[0], SIDE, padding=0)]
    answer = solve(scene, texels, Settings(resolution=SIDE, tolerance=1e-3, bounces=8))
    across = (np.arange(16) + 0.5) / 16 * 2 - 1
    outs = [(x * width / 2, y * width / 4, HIGH) for x in across for y in across] if width else [(0, 0, HIGH)]
    expected = np.mean([through_plate(own.positions, np.array(out)) for out in outs], axis=0)
    got = answer.images[0].reshape(-1, 3)[own.texel]
    np.testing.assert_allclose(got.mean(0), expected.mean() * lamp().intensity, rtol=2e-3)
    assert ((got[:, 0] - expected) ** 2).mean() < 1e-3 * (expected**2).mean()
    work = answer.diagnostics
    total = sum(work.flux_received.values()) + sum(work.flux_lost.values())
    np.testing.assert_allclose(total, work.flux_in, rtol=1e-9)


def test_what_meets_a_ball_is_what_the_lamp_sends_there():
    """The ball's form factor: pi I (r / d)^2 of a small flat lamp that faces it, and nothing of one that looks away."""
    for facing, share in ((DOWN, 1.0), (-DOWN, 0.0)):
        light = Area("Lamp", np.array([0, 0, HIGH]), np.ones(3), frame=facing)
        scene = Scene(no_water(), (floor(side=1.0, z=-1.0),), (), (light,), casters=(ball(0.4, fine=96),))
        texels = [rasterise(scene.receivers[0], 16, padding=0)]
        work = solve(scene, texels, Settings(resolution=16, tolerance=0.1)).diagnostics
        assert work.flux_in[0] == pytest.approx(share * np.pi * (0.4 / HIGH) ** 2, rel=5e-3)


@pytest.mark.parametrize("method", ["photon_splat", "conic_walk", "flat", "auto"])
def test_through_still_water(method):
    """All methods bring what the same lamp as 16 single ones brings."""
    bed, texels = floor(side=1.5), [rasterise(floor(side=1.5), SIDE, padding=0)]
    over = water(flat, quads=24, side=3.0, level=1.0)
    scene = Scene(over, (bed,), (), (lamp(1.0),))
    answer = solve(scene, texels, Settings(method, resolution=SIDE, tolerance=1e-3))
    apart, said = in_patches(scene, texels)
    assert len(apart.lights) == 16 and "16 points all over the area lamp 'Lamp'" in said[0]
    assert said[0] in answer.diagnostics.left_out
    singles = [
        solve(Scene(over, (bed,), (), (one,)), texels, Settings("flat", resolution=SIDE)).images[0]
        for one in apart.lights
    ]
    got, expected = answer.images[0][2:-2, 2:-2], sum(singles)[2:-2, 2:-2]
    assert got.mean() == pytest.approx(expected.mean(), rel=2e-3)
    assert ((got - expected) ** 2).mean() < 1e-3 * (expected**2).mean()


@pytest.mark.parametrize("half_angle", [0.05, 0.5, 1.2, np.pi / 2])
def test_a_grid_takes_no_light(half_angle):
    patch = Patch("Lamp", np.zeros(3), np.ones(3), half_angle=half_angle)
    angle = (np.arange(20000) + 0.5) / 20000 * np.pi / 2
    flux = (patch.falloff(np.cos(angle)) * 2 * np.pi * np.sin(angle)).sum() * np.pi / 2 / len(angle)
    assert flux == pytest.approx(np.pi, rel=1e-4)
    assert not patch.falloff(np.cos(angle[angle > half_angle])).any() and not patch.falloff(np.array([-0.5])).any()


@pytest.mark.parametrize("round_one", [False, True])
def test_points_lie_evenly_all_over_the_lamp(round_one):
    scene = Scene(water(flat, quads=4, side=3.0, level=1.0), (floor(side=1.0),), (), (lamp(1.0, round=round_one),))
    lights = in_patches(scene, [rasterise(scene.receivers[0], 64)])[0].lights
    place = np.array([one.position for one in lights])[:, :2] / [0.5, 0.25]
    assert (np.linalg.norm(place, axis=1).max() if round_one else np.abs(place).max()) < 0.95
    np.testing.assert_allclose(place.T @ place / 16, (1 / 4 if round_one else 1 / 3) * np.eye(2), atol=1e-12)
    np.testing.assert_allclose(place.mean(0), 0, atol=1e-12)
    assert len({one.name for one in lights}) == 16
    assert sum(one.intensity[0] for one in lights) == pytest.approx(1)


def test_a_small_lamp_is_one_point_at_its_middle():
    scene = Scene(water(flat, quads=4, side=3.0, level=1.0), (floor(side=1.0),), (), (lamp(0.01),))
    (light,), said = (lambda found, said: (found.lights, said))(*in_patches(scene, [rasterise(floor(side=1.0), 16)]))
    np.testing.assert_array_equal(light.position, [0, 0, HIGH])
    assert said == []


def test_sides_that_are_none():
    with pytest.raises(ValueError, match="sides must have shape"):
        Area("Lamp", np.zeros(3), np.ones(3), sides=np.zeros(3))
