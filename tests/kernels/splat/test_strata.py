"""One point in each part of a triangle, uniform over it."""

import numpy as np
import pytest

from dapple.kernels.splat.strata import linear, squared_length, strata


@pytest.mark.parametrize("m", [1, 2, 3, 7])
def test_each_congruent_part_gets_one_point(m):
    _, a, b, *_ = strata(m, np.random.default_rng(m))
    assert (a >= 0).all() and (b >= 0).all() and (a + b <= 1).all()
    i, j = np.floor(a * m), np.floor(b * m)
    upright = (a * m - i) + (b * m - j) < 1
    assert len(set(zip(i, j, upright, strict=True))) == m * m


def test_points_are_uniform():
    rng = np.random.default_rng(0)
    moments = np.mean([strata(2, rng).mean(1) for _ in range(20000)], axis=0)
    # Means of 1, a, b, a^2, a b, b^2 over the triangle.
    np.testing.assert_allclose(moments, [1, 1 / 3, 1 / 3, 1 / 6, 1 / 12, 1 / 6], atol=1e-3)


def test_forms_interpolate():
    rng = np.random.default_rng(2)
    vectors, triangles = rng.normal(size=(5, 3)), np.array([[0, 1, 2], [4, 3, 2]])
    points = strata(3, rng)
    weights = np.stack([1 - points[1] - points[2], points[1], points[2]])
    at = np.einsum("cm,tcx->tmx", weights, vectors[triangles])
    np.testing.assert_allclose(linear(vectors[:, 1], triangles) @ points[:3], at[..., 1], atol=1e-14)
    np.testing.assert_allclose(squared_length(vectors, triangles) @ points, (at**2).sum(-1), atol=1e-13)
