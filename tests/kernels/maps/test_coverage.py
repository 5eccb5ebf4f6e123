"""Exact coverage against areas known in closed form and against point counting."""

import numpy as np
import pytest

from dapple.kernels.maps import coverage


def polygon(points, weight=1.0):
    points = np.asarray(points, float)
    return points.T, np.roll(points, -1, axis=0).T, np.full((1, len(points)), weight)


def edge_coverage(starts, ends, weights, shape):
    """Of one channel."""
    return coverage.edge_coverage(starts, ends, weights, shape)[0]


def test_rectangle_covers_its_overlap_with_every_cell():
    covered = edge_coverage(*polygon([[1.25, 0.5], [3.5, 0.5], [3.5, 2.0], [1.25, 2.0]]), (4, 5))
    expected = np.outer([0.5, 1.0, 0, 0], [0, 0.75, 1, 0.5, 0])
    np.testing.assert_allclose(covered, expected, atol=1e-14)


def test_half_a_cell_under_its_diagonal():
    covered = edge_coverage(*polygon([[0, 0], [2, 0], [2, 2]]), (2, 2))
    np.testing.assert_allclose(covered, [[0.5, 1], [0, 0.5]], atol=1e-14)


def test_clockwise_counts_negative_and_weights_scale():
    covered = edge_coverage(*polygon([[0, 0], [0, 1], [1, 1], [1, 0]], weight=3.0), (1, 2))
    np.testing.assert_allclose(covered, [[-3, 0]], atol=1e-14)


def test_random_triangles_keep_their_area_and_agree_with_point_counting():
    rng = np.random.default_rng(3)
    side, fine = 8, 64
    centre = (np.arange(side * fine) + 0.5) / fine
    x, y = np.meshgrid(centre, centre)
    checked = 0
    for _ in range(20):
        corner = rng.random((3, 2)) * side
        (e1, e2) = corner[1:] - corner[0]
        area = (e1[0] * e2[1] - e1[1] * e2[0]) / 2
        covered = edge_coverage(*polygon(corner), (side, side))
        assert covered.sum() == pytest.approx(area, abs=1e-12)
        inside = np.ones_like(x, bool)
        for a, b in zip(corner, np.roll(corner, -1, axis=0), strict=True):
            inside &= np.sign(area) * ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) >= 0
        counted = inside.reshape(side, fine, side, fine).mean((1, 3))
        np.testing.assert_allclose(np.abs(covered), counted, atol=2.5 / fine)
        checked += 1
    assert checked == 20


def test_two_triangles_of_a_square_leave_no_crack():
    cut = [[0.3, 0.2], [5.7, 0.9], [4.1, 5.2], [0.8, 4.4]]
    whole = edge_coverage(*polygon(cut), (6, 6))
    parts = edge_coverage(*polygon([cut[0], cut[1], cut[2]]), (6, 6)) + edge_coverage(
        *polygon([cut[0], cut[2], cut[3]]), (6, 6)
    )
    np.testing.assert_allclose(whole, parts, atol=1e-13)


def test_what_lies_above_the_grid_covers_nothing():
    assert not edge_coverage(*polygon([[0, 7], [2, 7], [2, 9]]), (4, 5)).any()


def test_nothing_covers_nothing():
    empty = np.zeros((2, 0))
    assert edge_coverage(empty, empty, np.zeros((1, 0)), (3, 3)).sum() == 0


@pytest.mark.parametrize("seed", range(40))
def test_what_lies_beyond_the_grid_is_cut_off_exactly(seed):
    """A grid is a window on a larger one, wherever the polygons reach, level, upright and wide edges included."""
    rng = np.random.default_rng(seed)
    corner = rng.uniform(-6, 12, (4, 2)) * rng.choice([1, 1, 0.2], 2)
    if seed % 3 == 0:
        corner = np.round(corner)
    whole = edge_coverage(*polygon(corner + 8), (24, 24))
    np.testing.assert_allclose(edge_coverage(*polygon(corner), (6, 5)), whole[8:14, 8:13], atol=1e-12)


def test_channels_share_one_cut():
    starts, ends, _ = polygon([[0.3, 0.2], [5.7, 0.9], [4.1, 5.2]])
    both = coverage.edge_coverage(starts, ends, np.array([[1.0] * 3, [2.5] * 3]), (6, 6))
    np.testing.assert_allclose(both[1], 2.5 * both[0], atol=1e-14)


def test_edges_shared_by_two_triangles_carry_the_difference():
    """Two densities on either side of one edge: five edges do for six."""
    a, b, c, d = np.array([[0.3, 0.2], [5.7, 0.9], [4.1, 5.2], [0.8, 4.4]])
    apart = edge_coverage(*polygon([a, b, c], 2.0), (6, 6)) + edge_coverage(*polygon([a, c, d], 5.0), (6, 6))
    starts, ends = np.stack([a, b, a, c, d], 1), np.stack([b, c, c, d, a], 1)
    shared = edge_coverage(starts, ends, np.array([[2.0, 2.0, 5.0 - 2.0, 5.0, 5.0]]), (6, 6))
    np.testing.assert_allclose(shared, apart, atol=1e-13)
