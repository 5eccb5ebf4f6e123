"""Normals for the corners of small triangles that, interpolated between them, are right in the mean.

Linear interpolation of f between exact values errs to one side: over a triangle with edges e, where f has the second
derivatives H, its mean is too large by the sum of e.H e over the three edges / 24. Corners that are lower by as much
leave an error of mean zero, with a third to a sixth of the mean square, by the shape of f.
"""

from __future__ import annotations

import numpy as np


def evened(normals, bends, tessellation):
    """Unit normals (3,n) at all vertices of a Tessellation, from those on the surface, (3,n), and from bends (3,E): by
    how much they depart, in the middles of its edges, from the mean of the edges' ends."""
    k, edges, corners = tessellation.k, tessellation.edges.T, tessellation.inner
    inside = (k - 1) * (k - 2) // 2
    count = normals.shape[1] - bends.shape[1] * (k - 1) - corners.shape[1] * inside
    # e.H e is -8 bends, and a part's is k^-2 of its triangle's
    over = np.take(bends, edges, axis=1).sum(1) / (3 * k * k)
    of = [_means(over, corners, count)]
    if k > 1:
        of.append(np.repeat(_means(over, edges, bends.shape[1]), k - 1, axis=1))
    out = normals + np.concatenate([*of, np.repeat(over, inside, axis=1)], axis=1)
    return out / np.maximum(np.sqrt((out**2).sum(0)), np.finfo(float).tiny)


def _means(values, index, count):
    """Means (3,count) of the values (3,n) whose columns of index (3,n) name each; 0 where none does."""
    index = index.ravel()
    sums = [np.bincount(index, np.tile(row, 3), minlength=count) for row in values]
    return np.stack(sums) / np.maximum(np.bincount(index, minlength=count), 1)
