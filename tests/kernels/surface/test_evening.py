"""Evened corners: right in the mean, and nearer to a curved function than its own values."""

import numpy as np
import pytest
from waves import grid

from dapple.kernels.halfedges import build_twins
from dapple.kernels.surface.evening import evened
from dapple.kernels.surface.tessellate import Tessellation

SMALL = 1e-4  # so that to unit length is no change but in z


def lean(x, y):
    """Two functions with constant second derivatives."""
    return SMALL * (0.7 * x * x + 0.4 * x * y - 0.2 * y * y + x), SMALL * (0.3 * y * y - x * y - 2 * y)


def normals_of(x, y):
    return np.stack([*lean(x, y), np.ones_like(x)])


def tessellated(k, quads=6, jitter=0.0):
    """A Tessellation of a square, and x, y (2,n) of its vertices."""
    x, y, triangles = grid(quads, 2.0)
    inner = np.maximum(np.abs(x), np.abs(y)) < 0.99
    plan = np.stack([x, y]) + np.random.default_rng(0).uniform(-jitter, jitter, (2, len(x))) * inner
    parts = Tessellation(triangles, build_twins(triangles), len(x), np.ones(len(triangles), bool), k)
    groups = zip((parts.ends, parts.inner), parts.shares(), strict=True)
    return parts, np.concatenate(
        [plan, *(np.einsum("icn,cm->inm", plan[:, e], s).reshape(2, -1) for e, s in groups)], 1
    )


def errors(parts, plan, normals):
    """Means (2,t) over the parts that touch no rim, and mean of the square, of what is interpolated less the truth."""
    inside = (np.abs(plan).max(0)[parts.triangles] < 0.6).all(1)
    corner = parts.triangles[inside]
    share = np.random.default_rng(1).dirichlet(np.ones(3), 4000).T
    x, y = np.einsum("itc,cm->itm", plan[:, corner], share)
    off = np.einsum("itc,cm->itm", normals[:2, corner], share) - np.stack(lean(x, y))
    return off.mean(2), (off**2).mean()


def even(parts, plan):
    normals = normals_of(*plan)
    ends, middle = plan[:, parts.ends], plan[:, parts.ends].mean(1)
    return normals, evened(normals, normals_of(*middle) - normals_of(*ends).mean(1), parts)


@pytest.mark.parametrize("k", [1, 2, 3, 5])
def test_over_a_regular_lattice_the_mean_is_right(k):
    parts, plan = tessellated(k)
    exact, found = even(parts, plan)
    mean, before = errors(parts, plan, exact)
    assert np.abs(mean).max() > 0.1 * np.sqrt(before)
    mean, after = errors(parts, plan, found)
    assert np.abs(mean).max() < 0.05 * np.sqrt(before)  # as means of random points go
    assert after < before / 2.8
    np.testing.assert_allclose(np.linalg.norm(found, axis=0), 1, rtol=1e-12)


def test_over_other_lattices_it_is_better_as_well():
    parts, plan = tessellated(2, jitter=0.1)
    exact, found = even(parts, plan)
    assert errors(parts, plan, found)[1] < errors(parts, plan, exact)[1] / 2.5


def test_what_does_not_bend_stays():
    parts, plan = tessellated(3)
    normals = np.stack([0.1 + 0.2 * plan[0], 0.3 * plan[1], np.ones_like(plan[0])])
    normals /= np.linalg.norm(normals, axis=0)
    found = evened(normals, np.zeros((3, parts.ends.shape[1])), parts)
    np.testing.assert_allclose(found, normals, atol=1e-15)
