"""A focus and the dark round it in one map: each as bright as the closed form, fifty thousand to one."""

import numpy as np
import pytest
from casters import ball, no_water
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Scene, Settings

RADIUS, HEIGHT, HALF, SIDE, RINGS = 0.3, 0.45, 1.0, 256, 64
INDEX = 1.5


def _rings_of_a_ball(count=400_000):
    """Irradiance (RINGS,) on rings round the axis below a ball: light turned back by its outside, and light that went
    through it along 1 to 4 chords, for even shares of its cross-section."""
    b = np.sqrt((np.arange(count) + 0.5) / count)
    i, t = np.arcsin(b), np.arcsin(b / INDEX)
    s, p = (f(i - t) / g(i + t) for f, g in ((np.sin, np.sin), (np.tan, np.tan)))
    once, edges, flux = (s * s + p * p) / 2, np.linspace(0, HALF, RINGS + 1), np.zeros(RINGS)
    for chords in range(5):
        place = i + chords * (np.pi - 2 * t)  # from the top, where the last surface is met
        turned = 2 * (i - t) + (chords - 1) * (np.pi - 2 * t) if chords else 2 * i - np.pi
        weight = (1 - once) ** 2 * once ** (chords - 1) if chords else once
        down = np.cos(turned) > 1e-9
        fall = (RADIUS * np.cos(place) + HEIGHT) / np.where(down, np.cos(turned), 1)
        away = np.abs(RADIUS * np.sin(place) - fall * np.sin(turned))
        flux += np.histogram(away[down], edges, weights=weight[down] * np.pi * RADIUS**2 / count)[0]
    return flux / (np.pi * (edges[1:] ** 2 - edges[:-1] ** 2))


def test_a_focus_and_the_dark_are_both_as_bright_as_they_are():
    below = floor(side=2 * HALF)
    scene = Scene(no_water(), (below,), (), (sun((0, 0, -1)),), casters=(ball(RADIUS, (0, 0, HEIGHT), fine=128),))
    (own,) = texels = [rasterise(below, SIDE, padding=0)]
    image = solve(scene, texels, Settings(resolution=SIDE, tolerance=1e-2, surface="mesh")).images[0]
    light, part = image.reshape(-1, 3)[own.texel, 0] * own.area / 16, (np.arange(4) + 0.5) / 4 - 0.5
    found, texel, expected = np.zeros(RINGS), 2 * HALF / SIDE, _rings_of_a_ball()
    for x in part:
        for y in part:
            away = np.hypot(*(own.positions[:, :2] + texel * np.array([x, y])).T)
            found += np.histogram(away, RINGS, (0, HALF), weights=light)[0]
    edges = np.linspace(0, HALF, RINGS + 1)
    found /= np.pi * (edges[1:] ** 2 - edges[:-1] ** 2)
    assert expected.max() > 5e4 * expected.min()
    bright, dark = slice(0, 10), slice(40, RINGS - 4)
    np.testing.assert_allclose(found[bright], expected[bright], rtol=0.04)
    np.testing.assert_allclose(found[dark], expected[dark], rtol=0.1)
    assert found[dark].sum() == pytest.approx(expected[dark].sum(), rel=0.03)
