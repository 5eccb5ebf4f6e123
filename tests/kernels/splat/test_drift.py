"""What beams that lie beside their light leave, where they meet and where they tile."""

import numpy as np
import pytest

from dapple.kernels.splat.drift import Drift

SIDE = 32


def _beams(x, y, size, bent):
    """Rays (6,n) of right-angled triangles at x, y (n,) whose true images are moved by bent (2,) of their edges'
    middles."""
    corners = np.array([[0, 1, 0], [0, 0, 1]]) * size
    middles = (corners + np.roll(corners, -1, 1)) / 2 + np.asarray(bent)[:, None]
    six = np.concatenate([corners, middles], 1)
    return x + six[0][:, None], y + six[1][:, None]


def test_errors_of_beams_in_a_focus_add_up_before_they_are_squared():
    at = np.full(50, 15.97)
    one, many = Drift(1, SIDE), Drift(1, SIDE)
    one.add(np.zeros(1, int), *_beams(at[:1], at[:1], 0.1, (0.02, 0)), np.ones(1))
    many.add(np.zeros(50, int), *_beams(at, at, 0.1, (0.02, 0)), np.ones(50))
    assert one.error() == pytest.approx(2 * (0.02 / 0.1) ** 2) and many.error() == pytest.approx(2500 * one.error())


def test_light_goes_out_of_a_focus_within_one_texel_on_all_sides():
    """As vectors, four beams that move outwards make nothing."""
    drift = Drift(1, SIDE)
    for x, y, way in ((16.0, 16.5, (-1, 0)), (17.0, 16.5, (1, 0)), (16.5, 16.0, (0, -1)), (16.5, 17.0, (0, 1))):
        at = np.array([[x], [y]]) - 0.1 / 3
        drift.add(np.zeros(1, int), *_beams(*at, 0.1, 0.02 * np.array(way)), np.ones(1))
    assert drift.error() == pytest.approx((4 * 0.2) ** 2 + 4 * 0.2**2)


def test_narrow_beams_cross_a_border_as_often_as_they_are_near_it():
    """Beams anywhere: the sum over a border is the flux times how far it moves, however narrow they are."""
    x, y = 8.5 + np.random.default_rng(0).random((2, 20_000))
    for size in (0.02, 0.3, 0.6):
        drift = Drift(1, SIDE)
        drift.add(np.zeros(len(x), int), *_beams(x - size / 3, y - size / 3, size, (0.05, 0)), np.full(len(x), 1e-3))
        assert np.sqrt(drift.error() / 4) == pytest.approx(20 * 0.05 / 2, rel=0.1)  # over the border of two rows


def test_light_that_moves_everywhere_alike_moves_nothing():
    """Tiles of one flux, moved to one side: all that changes is at the rim."""
    x, y = (v.ravel() + 0.3 for v in np.meshgrid(np.arange(4, 28), np.arange(4, 28)))
    tiled, apart = Drift(1, SIDE), Drift(1, SIDE)
    tiled.add(np.zeros(len(x), int), *_beams(x, y, 1.0, (0.1, 0.0)), np.ones(len(x)))
    apart.add(np.zeros(len(x), int), *_beams(x, y, 1.0, (0.1, 0.0)), np.where((x + y).astype(int) % 4 < 2, 1.0, -1.0))
    assert 0 < tiled.error() < 0.2 * apart.error()


def test_opposite_ways_cancel_and_straight_edges_leave_nothing():
    at, across, image = np.full(1, 10.94), np.full(1, 10.4), np.zeros(1, int)
    drift = Drift(2, SIDE)
    drift.add(image, *_beams(at, across, 3.0, (0.0, 0.0)), np.ones(1))
    assert drift.error() == 0
    for sign in (1, -1):
        drift.add(image + 1, *_beams(at, across, 0.2, (sign * 0.05, 0.02 * sign)), np.ones(1))
        assert (drift.error() > 0.01) == (sign == 1)
    assert drift.error() == pytest.approx(0, abs=1e-20)


def test_a_quadratic_image_is_off_by_a_third_of_its_bends():
    """The centroid of x + b l1 l2 4 over a triangle: 4 b / 12 further on."""
    rng = np.random.default_rng(0)
    u, v = rng.random((2, 400_000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    bend = 0.3
    moved = (4 * bend * u * (1 - u - v)).mean()
    drift, x, y = Drift(1, SIDE), *_beams(np.array([5.8]), np.array([5.5]), 0.5, (0, 0))
    x[3] += bend
    drift.add(np.zeros(1, int), x, y, np.ones(1))
    assert drift.error() == pytest.approx(2 * (moved / 0.5) ** 2, rel=0.02)
