"""How far the slopes of a mesh are from those of the water, as far as its normals and its chords tell."""

from __future__ import annotations

import numpy as np

_SOFTENED = 6.0  # measured on 44 waters of tests/bench/estimate_ponds.py: 4 to 10
_LOOKED = 4096  # edges that deviations are taken from, at least


def some_edges(triangles):
    """Ends (2,n) of edges, evenly through the mesh."""
    some = triangles[:: max(1, 3 * len(triangles) // _LOOKED)]
    return np.concatenate([some[:, [0, 1]], some[:, [1, 2]], some[:, [2, 0]]]).T.astype(np.int64)


def own_deviation(water, edges):
    """The mesh's own error of slope (n,) along edges (2,n), as far as normals and chords tell, and lengths (n,)."""
    slopes, chord, length = _along(water, edges)
    return np.minimum(np.abs(slopes.mean(0) - chord), 1.0), length


def _along(water, edges):
    """Slopes (2,n) along edges (2,n) by the normals at both ends, those of the edges (n,) and their lengths (n,)."""
    x, y, z = (np.take(water.positions, edges[1], axis=0) - np.take(water.positions, edges[0], axis=0)).T
    length = np.sqrt(x * x + y * y)
    inverse = 1 / np.maximum(length, np.finfo(float).tiny)
    n = np.take(water.normals, edges, axis=0)
    rise = n[..., 0] * x + n[..., 1] * y
    up = n[..., 2]
    return -rise / np.where(up == 0, np.inf, up) * inverse, z * inverse, length


def rms(off, length):
    """Root mean square of `off`, by squared length: that is by area."""
    total = (length**2).sum()
    return float(np.sqrt((off**2 * length**2).sum() / total)) if total > 0 else 0.0


def softened(water):
    """How much more the variance of the light is than the normals of a Water's vertices tell: as means of facets they
    are softer than the waves, by the more the fewer vertices a wave has. That shows in their deviation from the chords,
    over the differences between them."""
    slopes, chord, length = _along(water, some_edges(water.triangles))
    off, bent = np.minimum(np.abs(slopes.mean(0) - chord), 1.0) * length, (slopes[1] - slopes[0]) * length
    return 1 + _SOFTENED * float(off @ off / (bent @ bent)) if bent.any() else 1.0
