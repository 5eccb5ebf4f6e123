"""Charts hang together where corners share a vertex and a UV."""

import numpy as np
from waves import grid, quad

from dapple.kernels.maps.charts import charts


def test_a_grid_is_one_chart_and_a_cut_makes_two():
    x, y, triangles = grid(12, 2.0)
    uvs = np.stack([x, y], 1)[triangles]
    assert (charts(triangles, uvs) == 0).all()
    right = x[triangles].mean(1) > 0
    uvs[right] += 0.5  # the right half moves away in UV space
    parts = charts(triangles, uvs)
    assert set(parts) == {0, 1}
    assert len(set(parts[right])) == len(set(parts[~right])) == 1


def test_touching_in_the_world_only_is_not_enough():
    floor = quad("Floor", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    apart = floor.uvs.copy()
    apart[1] = apart[1] / 2
    assert charts(floor.triangles, floor.uvs).tolist() == [0, 0]
    # One corner still shares vertex and UV (0, 0): that is a hinge, and a hinge holds.
    assert charts(floor.triangles, apart).tolist() == [0, 0]
    assert charts(floor.triangles, apart + np.array([0, 0.01])[:, None, None]).tolist() == [0, 1]


def test_a_long_strip_is_one_chart():
    count = 500
    low = np.arange(count)
    triangles = np.concatenate(
        [np.stack([low, low + 1, low + count + 2], 1), np.stack([low, low + count + 2, low + count + 1], 1)]
    )
    uvs = (
        np.stack([np.arange(2 * count + 2) % (count + 1), np.arange(2 * count + 2) // (count + 1)], 1)[triangles]
        / count
    )
    shuffled = np.random.default_rng(0).permutation(len(triangles))
    assert (charts(triangles[shuffled], uvs[shuffled]) == 0).all()
    assert len(charts(triangles[:0], uvs[:0])) == 0
