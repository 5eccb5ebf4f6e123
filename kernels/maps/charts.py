"""Charts of a UV map: the parts that hang together, across which a point moves without a jump."""

from __future__ import annotations

import numpy as np


def charts(triangles, uvs):
    """Chart of each triangle (T,), numbered from 0: triangles (T,3) hang together at corners of one vertex and one UV.

    uvs (T,3,2), one per corner.
    """
    if not len(triangles):
        return np.zeros(0, np.int64)
    rows = np.column_stack([triangles.ravel(), uvs.reshape(-1, 2)])
    _, corner = np.unique(rows, axis=0, return_inverse=True)
    return patches(corner.reshape(-1, 3))


def patches(corner):
    """A number for each of triangles corner (T,3), from 0, the same for those that hang together at corners that are
    numbered alike."""
    if not len(corner):
        return np.zeros(0, np.int64)
    label = np.arange(corner.max() + 1)
    while True:
        least = label[corner].min(1)
        lower = label.copy()
        np.minimum.at(lower, corner.ravel(), np.repeat(least, 3))
        np.minimum.at(lower, label[corner.ravel()], np.repeat(least, 3))  # whole groups at a time
        lower = lower[lower]
        if (lower == label).all():
            return np.unique(label[corner[:, 0]], return_inverse=True)[1].reshape(-1)
        label = lower
