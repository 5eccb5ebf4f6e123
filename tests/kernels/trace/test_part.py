"""Receivers of one size, and light that goes near them."""

from types import SimpleNamespace

import numpy as np
import pytest
from waves import floor

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.trace.follow import Rays
from dapple.kernels.trace.part import Near, Part, sizes


def of_side(side):
    """What stands for Texels of that side [m]."""
    return SimpleNamespace(area=np.full(10, side**2))


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        ([1.0], [[0]]),
        ([1.0, 0.6, 1.9, 1.0], [[0, 2, 3], [1]]),
        ([0.001, 0.01, 0.1, 0.09], [[2, 3], [1], [0]]),
        ([0.01, 0.00501], [[0, 1]]),
    ],
)
def test_texels_within_a_factor_of_two_are_of_one_size(sides, expected):
    found = sizes([of_side(side) for side in sides])
    assert [np.flatnonzero(own).tolist() for own in found] == expected
    np.testing.assert_array_equal(np.sum(found, axis=0), np.ones(len(sides)))


def test_maps_of_one_size_are_the_whole():
    own = sizes([rasterise(floor(side=1.0), 8), rasterise(floor(side=1.5), 8)])
    assert len(own) == 1 and Part(own[0]).whole and not Part(own[0], rest=False).whole
    assert Part(np.array([True, False])).of(["a", "b"]) == ["a"]


def test_light_passes_near_a_sphere_round_a_receiver_until_it_ends():
    half = np.sqrt(2) / 2  # a square of side 1: the sphere's radius
    origin = np.array([[0.0, half + 0.15, half + 0.25, 0.0, 0.0], [0] * 5, [2.0, 2, 2, 2, 2]])
    direction = np.array([[0.0] * 5, [0] * 5, [-1.0, -1, -1, -1, 1]])
    distance = np.array([2.0, np.inf, np.inf, 1.0, np.inf])
    near = Near([floor(side=1.0)])
    at = floor(side=1.0).positions[0, 2]
    rays = Rays.of(origin + np.array([[0], [0], [at]]), direction, 1)
    assert near.passed(rays, distance, lambda way: np.full(5, 0.1)).tolist() == [True, True, False, False, False]
    assert near.passed(rays, distance, lambda way: 0.15 * way / 2)[2], "light that spreads is wider further on"
