"""The fit: what it must reproduce, and how fast it nears a wave."""

import numpy as np
import pytest

from dapple.kernels.surface.fit import _roughness, _roughness_diagonal, fit

SMOOTHING = 2e-3


def scattered(count, seed=0):
    """x, y of points over a square of side 2, one in each cell of a grid, anywhere in it."""
    side = int(np.sqrt(count))
    rng = np.random.default_rng(seed)
    i = np.arange(side * side)
    corner = np.stack([i % side, i // side])
    return (corner + rng.uniform(0, 1, corner.shape)) * (2 / side) - 1


def fitted(shape, count, smoothing=SMOOTHING):
    x, y = scattered(count)
    return fit(np.stack([x, y, shape(x, y)], 1), 2 / np.sqrt(count), smoothing)


@pytest.mark.parametrize("smoothing", [SMOOTHING, 1.0])
def test_a_plane_is_itself_to_rounding(smoothing):
    field = fitted(lambda x, y: 3 + 0.2 * x - 0.5 * y, 400, smoothing)
    x, y = scattered(900, 1)
    z, along_x, along_y = field.at(x, y)
    np.testing.assert_allclose(z, 3 + 0.2 * x - 0.5 * y, rtol=1e-13)
    np.testing.assert_allclose(along_x, 0.2, rtol=1e-11)
    np.testing.assert_allclose(along_y, -0.5, rtol=1e-11)


@pytest.mark.parametrize("smoothing", [SMOOTHING, 1.0])
def test_a_paraboloid_costs_no_roughness(smoothing):
    def bowl(x, y):
        return 0.3 * x * x - 0.1 * x * y + 0.2 * y * y

    x, y = scattered(900, 1) * 0.9
    z, along_x, along_y = fitted(bowl, 400, smoothing).at(x, y)
    np.testing.assert_allclose(z, bowl(x, y), atol=1e-4)
    np.testing.assert_allclose(along_x, 0.6 * x - 0.1 * y, atol=3e-3)
    np.testing.assert_allclose(along_y, 0.4 * y - 0.1 * x, atol=3e-3)


def test_slopes_of_a_wave_converge_with_the_third_power():
    def wave(x, y):
        return np.sin(4 * x) * np.cos(3 * y)

    x, y = scattered(2500, 1) * 0.9
    off = [np.abs(fitted(wave, n).at(x, y)[1] - 4 * np.cos(4 * x) * np.cos(3 * y)).max() for n in (400, 1600)]
    assert off[0] > 8 * off[1] and off[1] < 0.01


def test_the_roughness_is_symmetric_positive_and_has_its_diagonal():
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal((2, 6, 9))
    assert (a * _roughness(b)).sum() == pytest.approx((b * _roughness(a)).sum(), rel=1e-12)
    assert (a * _roughness(a)).sum() > 0
    for cell in ((0, 0), (3, 4), (5, 2)):
        unit = np.zeros((6, 9))
        unit[cell] = 1
        assert _roughness(unit)[cell] == pytest.approx(_roughness_diagonal((6, 9))[cell])


def test_few_points_and_points_in_a_row_give_a_surface_through_them():
    for points in (
        np.array([[0, 0, 1.0], [1, 0, 2.0], [0, 1, 3.0]]),
        np.array([[0, 0, 1.0], [1, 0, 2.0], [2, 0, 3.0]]),
        np.array([[0, 0, 1.0]]),
    ):
        z, *_ = fit(points, 1.0, SMOOTHING).at(points[:, 0], points[:, 1])
        np.testing.assert_allclose(z, points[:, 2], atol=1e-9)
