"""Vectors across triangles and the sums of their normals, in blocks, against one triangle at a time."""

import numpy as np

from dapple.kernels import facets
from dapple.kernels.facets import Facets


def test_blocks_make_what_single_triangles_do(monkeypatch):
    rng = np.random.default_rng(0)
    monkeypatch.setattr(facets, "_BLOCK", 7)
    positions, normals = rng.normal(size=(20, 3)), rng.normal(size=(30, 3))
    triangles, shading = rng.integers(0, 20, (25, 3)), rng.integers(0, 30, (25, 3))
    found = Facets.of(positions, normals, triangles, shading)
    for k, (a, b, c) in enumerate(positions[triangles]):
        np.testing.assert_allclose(found.across[:, k], np.cross(b - a, c - a), rtol=1e-13)
        np.testing.assert_allclose(found.leaning[:, k], normals[shading[k]].sum(0), rtol=1e-13)
        assert found.outward()[:, k] @ found.leaning[:, k] >= 0
        np.testing.assert_allclose(np.abs(found.outward()[:, k]), np.abs(found.across[:, k]))


def test_shared_indices_are_looked_up_once_and_mean_the_same():
    rng = np.random.default_rng(1)
    positions, normals, triangles = rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), rng.integers(0, 9, (12, 3))
    one = Facets.of(positions, normals, triangles, triangles)
    other = Facets.of(positions, normals, triangles, triangles.copy())
    np.testing.assert_array_equal(one.leaning, other.leaning)
