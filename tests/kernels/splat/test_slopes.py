"""How steep water is, against planes and tents, and how many sheets of it lie over each other."""

import numpy as np
import pytest
from waves import grid

from dapple.kernels.halfedges import build_twins
from dapple.kernels.splat.slopes import sheets, slopes_round, squared_slopes, steepness


def test_a_plane_is_as_steep_as_its_gradient():
    across = np.array([[-0.3, 0.4, 1.0], [0.0, 0.0, 2.0], [0.3, 0.4, -1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]).T
    np.testing.assert_allclose(squared_slopes(across), [0.25, 0, np.inf, np.inf, 0])


def test_the_steepest_edge_or_normal_counts():
    corners = np.array([[[0, 0, 0], [1, 0, 0.5], [0, 1, 0]]], float)
    up = np.tile([0.0, 0.0, 1.0], (1, 3, 1))
    assert slopes_round(corners, up)[0] == pytest.approx(0.25)
    up[0, 1] = [0.8, 0, 0.6]
    assert slopes_round(corners, up)[0] == pytest.approx((0.8 / 0.6) ** 2)


def test_directions_that_go_down_are_below_nought():
    assert steepness(np.array([[1.0, 0.0], [0.0, 2.0], [1.0, -1.0]])) == -0.5
    assert steepness(np.array([[0.0], [0.0], [1.0]])) > 1e9


@pytest.mark.parametrize("count", [1, 2, 3])
def test_sheets_are_counted_where_they_overlap(count):
    x, y, triangles = grid(4, 2.0)
    positions = np.concatenate([np.stack([x + 0.3 * k, y, 0 * x + k], 1) for k in range(count)])
    triangles = np.concatenate([triangles + k * len(x) for k in range(count)])
    assert sheets(positions, triangles, build_twins(triangles)) == pytest.approx(count)
