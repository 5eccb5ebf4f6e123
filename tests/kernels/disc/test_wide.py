"""Ellipses of many texels: what can reach no other texel of the chart is left out, and makes no difference."""

import numpy as np
import pytest

from dapple.kernels.disc import wide
from dapple.kernels.disc.kernels import kernel


@pytest.mark.parametrize("half", [3.0, 30.0])
def test_the_blur_is_the_sum_over_all_pairs_of_cells(half):
    """Against a sum in the open, with an ellipse within the chart and one that is larger than it."""
    rng = np.random.default_rng(3)
    flux, on = rng.random((11, 17)), np.ones((11, 17), bool)
    moments = np.array([[half**2], [half**2 / 2], [half**2 / 4]])
    blurred = wide.blur_wide(flux, on, np.zeros(flux.shape, int), moments)
    shares = kernel(moments[:, 0])
    middle = len(shares) // 2
    padded = np.pad(shares, max(flux.shape))
    open_sum, even = np.zeros(flux.shape), np.zeros(flux.shape)
    for y, x in np.ndindex(flux.shape):
        corner = middle + max(flux.shape) - y, middle + max(flux.shape) - x
        reach = padded[corner[0] : corner[0] + 11, corner[1] : corner[1] + 17]
        open_sum += flux[y, x] * reach
        even += reach
    mean = open_sum / even
    margin = mean * (1 - even)
    expected = mean + margin * (flux.sum() - mean.sum()) / margin.sum()
    np.testing.assert_allclose(blurred, expected, rtol=1e-9)
    assert blurred.sum() == pytest.approx(flux.sum(), rel=1e-12)


def test_even_light_stays_even_up_to_the_borders():
    """On a chart of any form, under ellipses that differ from texel to texel."""
    rows, columns = np.indices((20, 30))
    on = (rows - 10) ** 2 + (columns - 12) ** 2 < 81
    home = np.where(on, np.cumsum(on).reshape(on.shape) - 1, 0)
    half = np.linspace(4.0, 9.0, on.sum())
    moments = np.array([half**2, half**2 / 3, half**2 / 5]) / 4
    blurred = wide.blur_wide(np.where(on, 2.5, 7.0), on, home, moments)
    np.testing.assert_allclose(blurred, np.where(on, 2.5, 7.0), rtol=1e-9)


def test_kernels_are_cut_to_what_joins_cells_of_the_chart():
    shares = np.arange(49.0).reshape(7, 7)
    assert wide._within(shares, 4) is shares
    np.testing.assert_array_equal(wide._within(shares, 2), shares[2:5, 2:5])
    assert wide._within(shares, 1).shape == (1, 1)
