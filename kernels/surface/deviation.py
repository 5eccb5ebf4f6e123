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
    run = water.positions[edges[1]] - water.positions[edges[0]]
    length = np.hypot(run[:, 0], run[:, 1])
    normals = water.normals[edges]
    rise = -(normals[:, :, :2] * run[:, :2]).sum(2) / np.where(normals[:, :, 2] == 0, np.inf, normals[:, :, 2])
    off = np.abs(rise.mean(0) - run[:, 2]) / np.maximum(length, np.finfo(float).tiny)
    return np.minimum(off, 1.0), length


def rms(off, length):
    """Root mean square of `off`, by squared length: that is by area."""
    total = (length**2).sum()
    return float(np.sqrt((off**2 * length**2).sum() / total)) if total > 0 else 0.0


def softened(water):
    """How much more the variance of the light is than the normals of a Water's vertices tell: as means of facets they
    are softer than the waves, by the more the fewer vertices a wave has. That shows in their deviation from the chords,
    over the differences between them."""
    edges = some_edges(water.triangles)
    off, length = own_deviation(water, edges)
    run = water.positions[edges[1], :2] - water.positions[edges[0], :2]
    normals = water.normals[edges]
    slopes = -(normals[:, :, :2] * run).sum(2) / np.where(normals[:, :, 2] == 0, np.inf, normals[:, :, 2])
    bent = (slopes[1] - slopes[0]) @ (slopes[1] - slopes[0])
    return 1 + _SOFTENED * float((off * length) @ (off * length) / bent) if bent > 0 else 1.0
