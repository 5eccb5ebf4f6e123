"""Numbers for points, by which those that are the same are found, and those near each other lie together."""

from __future__ import annotations

import numpy as np

_PLACE = 24  # bits of a number for where a point is, eight for each axis
_SPREAD = sum(((np.arange(256) >> k & 1) << 3 * k for k in range(8)), np.int64(0)).astype(np.uint64)  # bits, apart
_MIX = np.uint64(0x9E3779B97F4A7C15)


def keys(m, width):
    """Numbers (k,) uint64 of points m (3,k) [m]: where they are along Morton's curve through cells of a width [m], 256
    along each side and then from the start again, and below that what tells those in one cell apart."""
    key = np.zeros(m.shape[1], np.uint64)
    for row in m:
        key ^= np.ascontiguousarray(row).view(np.uint64)
        key ^= key >> np.uint64(32)
        key *= _MIX
        key ^= key >> np.uint64(29)
    cell = np.floor(m / width).astype(np.int64) & 255
    place = sum(np.take(_SPREAD << np.uint64(k), cell[k]) for k in range(3))
    return key >> np.uint64(_PLACE) | place << np.uint64(64 - _PLACE)
