"""B-splines against their definition."""

import numpy as np
import pytest

from dapple.kernels.surface.bspline import Lattice, Samples, evaluate, insert_knots, pieces, slopes

LATTICE = Lattice(np.array([-1.0, 2.0]), np.array([0.25, 0.4]), (5, 8))


@pytest.fixture
def points():
    rng = np.random.default_rng(0)
    return rng.uniform([-1, 2], [1, 4], (200, 2)).T


def test_pieces_sum_to_one_and_slopes_are_their_derivatives():
    u, h = np.linspace(0, 1, 21), 1e-6
    np.testing.assert_allclose(pieces(u).sum(0), 1, rtol=1e-14)
    np.testing.assert_allclose((pieces(u + h) - pieces(u - h)) / (2 * h), slopes(u), atol=1e-9)


def test_values_are_the_tensor_products(points):
    c = np.random.default_rng(1).standard_normal(LATTICE.shape)
    x, y = points

    def bump(t):  # the cubic B-spline on knots -2 to 2
        t = np.abs(t)
        return np.where(t < 1, (4 - 6 * t**2 + 3 * t**3) / 6, np.maximum(2 - t, 0) ** 3 / 6)

    column = bump((x[:, None] + 1) / 0.25 - (np.arange(11) - 1))
    row = bump((y[:, None] - 2) / 0.4 - (np.arange(8) - 1))
    expected = np.einsum("nj,ji,ni->n", row, c, column)
    np.testing.assert_allclose(evaluate(LATTICE, c, x, y)[0], expected, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(Samples(LATTICE, x, y).values(c), expected, rtol=1e-12, atol=1e-14)


def test_slopes_are_differences_of_values(points):
    c = np.random.default_rng(2).standard_normal(LATTICE.shape)
    x, y = points
    h = 1e-6
    _, along_x, along_y = evaluate(LATTICE, c, x, y)
    np.testing.assert_allclose(
        (evaluate(LATTICE, c, x + h, y)[0] - evaluate(LATTICE, c, x - h, y)[0]) / (2 * h), along_x, atol=1e-7
    )
    np.testing.assert_allclose(
        (evaluate(LATTICE, c, x, y + h)[0] - evaluate(LATTICE, c, x, y - h)[0]) / (2 * h), along_y, atol=1e-7
    )


def test_spread_is_the_transpose_of_values(points):
    rng = np.random.default_rng(3)
    samples = Samples(LATTICE, *points)
    c, z = rng.standard_normal(LATTICE.shape), rng.standard_normal(200)
    assert (samples.values(c) * z).sum() == pytest.approx((c * samples.spread(z)).sum(), rel=1e-12)
    unit = np.zeros(LATTICE.shape)
    unit[3, 4] = 1
    assert samples.spread(samples.values(unit))[3, 4] == pytest.approx(samples.diagonal[3, 4], rel=1e-12)


def test_more_knots_are_the_same_spline(points):
    c = np.random.default_rng(4).standard_normal(LATTICE.shape)
    fine = LATTICE.halved()
    np.testing.assert_allclose(
        evaluate(fine, insert_knots(c), *points), evaluate(LATTICE, c, *points), rtol=1e-10, atol=1e-12
    )
