"""Cells of an entry: their neighbours, and those that are cut in four."""

import numpy as np
import pytest
from waves import sun

from dapple.kernels.scene import Point
from dapple.kernels.trace.entry import Entry

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
LIGHTS = [sun((0.3, 0.1, -1)), Point("Lamp", np.array([0.4, 0.6, 0.7]), np.ones(3))]


def entry(light, width=0.05):
    return Entry(light, CORNERS[[[0, 1, 2], [0, 2, 3]]], np.append(CORNERS, [[0, 0, 1.0]], 0), width)


@pytest.mark.parametrize("light", LIGHTS, ids=["sun", "lamp"])
def test_sums_round_each_cell_are_those_of_the_cells_beside_it(light):
    own = entry(light)
    values = np.random.default_rng(0).random(own.place.shape[1])
    beside = np.abs(own.place[:, :, None] - own.place[:, None]).max(0) <= 1
    np.testing.assert_allclose(own.around(values), beside @ values, rtol=1e-12)
    np.testing.assert_array_equal(own.around(values > 0.5), beside @ (values > 0.5).astype(int))


@pytest.mark.parametrize("light", LIGHTS, ids=["sun", "lamp"])
def test_four_cells_fill_one(light):
    own = entry(light)
    chosen = np.random.default_rng(1).random(own.place.shape[1]) > 0.7
    finer = own.finer(chosen)
    assert finer.place.shape[1] == 4 * np.count_nonzero(chosen) > 100
    corners, parts = (e.lit.points[e.lit.triangles].reshape(-1, 6, 3) for e in (own, finer))
    low, high = (f(corners[chosen], axis=1) for f in (np.min, np.max))
    middle = (parts.min(1) + parts.max(1))[:, None] / 2
    inside = ((middle > low) & (middle < high))[..., :2].all(2)
    np.testing.assert_array_equal(inside.sum(0), 4)
    np.testing.assert_array_equal(inside.sum(1), 1)
    whole, cut = (e.lit.area.reshape(-1, 2).sum(1) for e in (own, finer))
    np.testing.assert_allclose((inside * cut[:, None]).sum(0), whole[chosen], rtol=1e-2 if light is LIGHTS[1] else 1e-9)


def test_no_cell_is_left_of_none_chosen():
    own = entry(LIGHTS[0])
    none = own.finer(np.zeros(own.place.shape[1], bool))
    assert none.place.shape == (2, 0) and none.around(np.zeros(0)).shape == (0,)
    assert none.finer(np.zeros(0, bool)).lit.area.shape == (0,)
