"""Points with footprints: nothing is lost, nothing lands where none was seen to, and a sheet of them is smooth."""

import numpy as np
import pytest

from dapple.kernels.trace.scatter import Points, Scatter, keys

SIDE = 32
BOX = np.array([[[2.0], [2.0]], [[30.0], [20.0]]])  # of the chart


def scattered(stratum, x, y, way=0, flux=None, wide=0.0):
    """Flux (2, SIDE, SIDE): all, and the even points' less the odd ones'."""
    stratum, count = np.asarray(stratum), len(x)
    flux = np.ones((1, count)) if flux is None else flux
    scatter = Scatter(np.zeros(1, int), 1, SIDE, 1, BOX)
    even = stratum.sum(0) % 2 == 0
    key = keys(stratum, np.broadcast_to(way, count))
    scatter.add(
        Points(key, even, np.zeros(count, int), np.asarray(x, float), np.asarray(y, float), flux, np.full(count, wide))
    )
    both, apart, landed = scatter.take()
    assert both.sum() == pytest.approx(flux.sum()) and landed.sum() == pytest.approx(flux.sum())
    return both.reshape(SIDE, SIDE), apart.reshape(SIDE, SIDE)


def test_a_lone_point_lies_in_its_texel():
    both, apart = scattered([[3], [4]], [5.5], [7.5])
    assert both[7, 5] == 1 and apart[7, 5] == -1


def test_a_regular_sheet_is_even_within_its_points():
    i, j = (v.ravel() for v in np.meshgrid(np.arange(5), np.arange(5)))
    both, _ = scattered([i, j], 4.0 + 5 * i, 4.0 + 5 * j)
    np.testing.assert_allclose(both[9:19, 9:19], 1 / 25, rtol=1e-9)
    assert not both[:4].any() and not both[24:].any() and not both[:, :4].any() and not both[:, 24:].any()


def test_light_that_went_another_way_is_no_neighbour():
    both, _ = scattered([[3, 4], [4, 4]], [5.5, 15.5], [7.5, 7.5], way=[1, 2])
    assert both[7, 5] == 1 and both[7, 15] == 1
    both, _ = scattered([[3, 5], [4, 4]], [5.5, 15.5], [7.5, 7.5])
    assert both[7, 5] == 1 and both[7, 15] == 1, "strata are apart"


def test_a_footprint_ends_halfway_to_its_neighbours():
    both, _ = scattered([[0, 1, 0, 1], [0, 0, 1, 1]], [4, 14, 4, 14], [6, 6, 12, 12], flux=np.array([[1.0, 2, 3, 4]]))
    for (y, x), flux in zip(((6, 4), (6, 9), (9, 4), (9, 9)), (1, 2, 3, 4), strict=True):
        np.testing.assert_allclose(both[y : y + 3, x : x + 5], flux / 15)


def test_a_lone_point_is_as_wide_as_it_speaks_for_within_its_chart():
    both, _ = scattered([[3], [4]], [11.0], [9.0], wide=4.0)
    np.testing.assert_allclose(both[7:11, 9:13], 1 / 16)
    both, _ = scattered([[3], [4]], [29.5], [2.5], wide=4.0)
    np.testing.assert_allclose(both[2:6, 26:30], 1 / 16)
    both, _ = scattered([[3], [4]], [11.0], [9.0], wide=24.0)
    np.testing.assert_allclose(both[2:20, 2:26], 1 / (18 * 24))


def test_points_with_neighbours_are_as_wide_as_these_say():
    narrow, _ = scattered([[3, 4], [4, 4]], [5.5, 15.5], [7.5, 7.5])
    wide, _ = scattered([[3, 4], [4, 4]], [5.5, 15.5], [7.5, 7.5], wide=4.0)
    np.testing.assert_array_equal(wide, narrow)
