"""Casters and water in one way of light: mirrors under it, its reflection between casters, all in a closed room."""

from dataclasses import replace

import numpy as np
import pytest
from casters import SILVER, ball, patch, room, slab
from waves import five_sines, flat, floor, quad, sun, transmitted, turned, water

from dapple.kernels.casters import Glass, Mirror
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Point, Scene, Settings, Water
from dapple.kernels.trace.cast import over_casters


def maps(scene, side=32, **settings):
    """The Solution of a Scene, its Texels, and the light (K,) in red of its casters alone."""
    texels = [rasterise(r, side, padding=0) for r in scene.receivers]
    asked = Settings(resolution=side, surface="mesh", **settings)
    light = sum(cast.spread()[0][:, 0] for cast in over_casters(scene, texels, asked))
    return solve(scene, texels, asked), texels, light / np.concatenate([t.area for t in texels])


def half(over):
    """The part of a Water where x > 0."""
    own = over.triangles[(over.positions[over.triangles, 0] > 0).all(1)]
    return Water(over.name, over.positions, own, over.normals, own, np.full(own.size, -1))


def test_a_mirror_under_water_is_a_window_to_the_floor_beyond_it():
    """Waves before an upright mirror, against the same waves without it, over the floor behind: its mirror image."""
    over = half(water(five_sines, quads=96, side=4.0, level=1.0))
    light = (sun((-0.8, 0.1, -1)),)
    far = 0.35  # beyond it light lands that passes above the mirror
    behind = quad("Behind", [[-far, -0.4, 0], [0, -0.4, 0], [0, 0.4, 0], [-far, 0.4, 0]])
    before = quad("Before", [[0, -0.4, 0], [far, -0.4, 0], [far, 0.4, 0], [0, 0.4, 0]])
    span = np.linspace(-2, 2, 5), np.linspace(-0.1, 0.9, 3)
    mirror = patch(lambda u, v: (0 * u, u, v), lambda u, v: (1 + 0 * u, 0 * u, 0 * u), *span, SILVER, "Mirror")
    plain, *_ = maps(Scene(over, (behind,), (), light), tolerance=1e-4)
    _, texels, mirrored = maps(Scene(over, (before,), (), light, casters=(mirror,)), tolerance=1e-4)
    expected = plain.images[0][:, ::-1, 0].ravel()[texels[0].texel]
    assert expected.mean() > 0.2 and mirrored.mean() == pytest.approx(expected.mean(), rel=2e-3)
    assert ((mirrored - expected) ** 2).mean() < 2e-3 * (expected**2).mean()


def test_a_mirror_under_still_water_by_the_closed_form():
    """Snell, Fresnel, the mirror's colour, and what the water takes on the way down and across to a wall."""
    sigma = np.array([0.3, 0.0, 1.0])
    tilted = patch(
        lambda u, v: (u, v, 0.5 + u), lambda u, v: (-np.sqrt(0.5) + 0 * u, 0 * u, np.sqrt(0.5) + 0 * u),
        np.linspace(-0.4, 0.4, 3), np.linspace(-0.4, 0.4, 3), Mirror(np.full(3, 0.8), np.full(3, 0.8)),
    )  # fmt: skip
    wall = quad("Wall", [[-1, -0.2, 0.3], [-1, 0.2, 0.3], [-1, 0.2, 0.7], [-1, -0.2, 0.7]])
    over = water(flat, quads=4, side=1.2, level=1.5)
    scene = Scene(over, (wall,), (), (sun((0, 0, -1)),), sigma_a=sigma, casters=(tilted,))
    answer, texels, _ = maps(scene, 8, tolerance=1e-4)
    height = texels[0].positions[:, 2]
    way = (1.5 - height) + (1 + height - 0.5)  # down to where the mirror is as high, and across
    expected = 0.8 * transmitted(1.0) * np.exp(-sigma * way[:, None])
    found = answer.images[0].reshape(-1, 3)[texels[0].texel]
    np.testing.assert_allclose(found.mean(0), expected.mean(0), rtol=2e-3)
    assert ((found - expected) ** 2).sum() < 1e-4 * (expected**2).sum()


def hull(z, half=0.5):
    """A receiver over the origin that looks down."""
    return turned(floor(side=2 * half, z=z))


def test_water_between_two_passes_through_a_plate():
    """Down through a plate, off the water, up through it: R_p + T_p^2 R_w / (1 - R_p R_w) comes to a hull above, with
    the plate's own reflection, over all orders between the two."""
    plate = slab((-3.5, -0.5, 0.5), (1.5, 0.5, 0.6))
    over = water(flat, quads=4, side=7.0, level=0.0)
    scene = Scene(over, (hull(1.5, 0.3),), (), (sun((1, 0, -1)),), casters=(plate,))
    answer, *_ = maps(scene, 8, tolerance=1e-3, bounces=9)
    cos_i = np.sqrt(0.5)
    once = 1 - transmitted(cos_i, 1.5)
    passes, off_water = (1 - once) / (1 + once), 1 - transmitted(cos_i)
    expected = cos_i * ((1 - passes) + passes**2 * off_water / (1 - (1 - passes) * off_water))
    assert answer.images[0][2:6, 2:6, 0].mean() == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("receiver", [floor(side=1.0), hull(1.9)], ids=["floor", "hull"])
def test_waves_light_floor_and_hull_through_a_plate_of_nothing_as_without_it(receiver):
    """A plate of the index of air bends nothing, but what passes it goes the casters' way: down to the water, and on to
    the bed or back through it to a hull. Without it the water's own beams and reflections bring the same."""
    plain = Scene(water(five_sines, quads=48, side=3.6, level=1.0), (receiver,), (), (sun((0.9, 0.2, -1)),))
    truth, texels, _ = maps(plain, 24, tolerance=1e-6)
    nothing = slab((-3, -2, 1.5), (2, 2, 1.6), Glass(1.0))
    found, *_ = maps(replace(plain, casters=(nothing,)), 24, tolerance=1e-4)
    expected, got = (answer.images[0][..., 0].ravel()[texels[0].texel] for answer in (truth, found))
    assert expected.mean() > 0.01 and got.mean() == pytest.approx(expected.mean(), rel=3e-3)
    assert ((got - expected) ** 2).mean() < 2e-3 * (expected**2).mean()


def test_energy_of_all_there_is_in_a_closed_room():
    """A glass ball, a mirror ball and water, which absorb nothing: all that meets them arrives, within 0.3 %."""
    casters = ball(0.4, (-0.7, 0, 0.3), fine=48), ball(0.3, (0.6, 0.4, 1.2), fine=48, material=SILVER, name="Silver")
    lamp = Point("Lamp", np.array([0.1, -0.3, 1.7]), np.ones(3))
    scene = Scene(water(flat, quads=16, side=4.0, level=-0.5), room(2.0), (), (lamp,), casters=casters)
    texels = [rasterise(r, 16, padding=0) for r in scene.receivers]
    (cast,) = over_casters(scene, texels, Settings(resolution=16, bounces=10))
    for flux, lost, met, _ in (cast.spread(), cast.throw(5e4, np.random.default_rng(0))):
        assert met[0] > 0.47
        assert flux[:, 0].sum() == pytest.approx(met[0], rel=3e-3), lost
