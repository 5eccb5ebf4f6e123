"""Exact area coverage: how much of each texel lies inside polygons, by Green's theorem on their edges.

An edge is cut at the grid's rows. A piece inside one row, of height dy, covers the texels that it passes in part and
dy of every texel further right; so it leaves the differences between neighbours on the texels from its lowest abscissa
to its highest, and a cumulative sum along x turns these into areas. Exact up to float64 rounding, for any polygons.
"""

from __future__ import annotations

import numpy as np

_BLOCK = 1 << 13  # edges at once: what a block touches stays in the second-level cache
_PENDING = 1 << 19  # differences between two bincounts, or as many as there are bins: these outgrow the cache


def edge_coverage(starts, ends, weights, shape):
    """Weighted area that the polygons bounded by directed edges cover in every cell.

    starts, ends (2,n): x, y of edges in texel units, counter-clockwise round what is covered, on the grid or beyond it;
    weights (C,n): density of each edge's polygon in C channels, or the difference of those on its left and right;
    shape (H, W). Returns (C, H, W) float64.
    """
    height, width = shape
    deposits = _Deposits(len(weights), height * (width + 3))
    for k in range(0, weights.shape[1], _BLOCK):
        block = slice(k, k + _BLOCK)
        _deposit(starts[:, block], ends[:, block], weights[:, block], shape, deposits)
    sums = deposits.take().reshape(-1, height, width + 3)
    return np.cumsum(sums, axis=2, out=sums)[:, :, :width]


class _Deposits:
    """Sums per cell and channel of what is added, gathered in batches."""

    def __init__(self, channels, cells):
        self._sums = np.zeros((channels, cells))
        self._pending, self._count = [], 0
        self._most = max(_PENDING, cells)

    def add(self, cell, values):
        """Add values (C,n) to cells (n,)."""
        self._pending.append((cell, values))
        self._count += len(cell)
        if self._count > self._most:
            self._flush()

    def take(self):
        self._flush()
        return self._sums

    def _flush(self):
        if self._count:
            cell = np.concatenate([c for c, _ in self._pending])
            low = cell.min()
            cell -= low
            for channel, sums in enumerate(self._sums):
                values = np.concatenate([v[channel] for _, v in self._pending])
                near = np.bincount(cell, values)  # edges come in the mesh's order: most batches touch a part
                sums[low : low + len(near)] += near
        self._pending, self._count = [], 0


def _deposit(starts, ends, weights, shape, deposits):
    """Add the deposits of one block of edges."""
    height, width = shape
    edge, row, xa, xb, rise = _rows(*starts, *ends, height)
    rise = np.take(-weights, edge, axis=1) * rise  # counter-clockwise, what is covered lies left of an upward edge
    left, right = np.minimum(xa, xb), np.maximum(xa, xb)
    low, high = np.clip(left, 0, width), np.clip(right, 0, width)
    out = np.flatnonzero((left < 0) | (right > width))
    if len(out):  # left of the grid it covers whole rows, right of it nothing
        before, within = _shares(left[out], right[out], low[out], high[out])
        deposits.add(row[out] * (width + 3), rise[:, out] * before)
        rise[:, out] *= within
    first = np.floor(low)
    cell = row * (width + 3) + first.astype(np.int64)
    low -= first
    high -= first
    wide = np.flatnonzero(high > 2)
    if len(wide):
        _add_wide(cell[wide], low[wide], high[wide], rise[:, wide], deposits)
        rise[:, wide] = 0
    _add_narrow(cell, low, high, rise, deposits)


def _shares(left, right, low, high):
    """Of pieces from `left` to `right`, of which low to high is on the grid: shares to the left of it and on it."""
    upright = left == right
    span = np.where(upright, 1.0, right - left)
    before = np.where(upright, left < 0, np.clip(np.minimum(right, 0) - left, 0, None) / span)
    return before, np.where(upright, left >= 0, (high - low) / span)


def _rows(x0, y0, x1, y1, height):
    """Cut edges at the rows: per piece its edge, its row, the abscissas of its lower and upper end, and its height,
    signed as the edge runs."""
    up = y1 > y0
    bottom, top = np.where(up, y0, y1), np.where(up, y1, y0)
    x = np.where(up, x0, x1)
    slope = (x1 - x0) / np.where(y1 == y0, 1.0, y1 - y0)
    low, high = np.maximum(bottom, 0.0), np.minimum(top, height)
    row = np.floor(low)
    count = np.where(high > low, np.ceil(high) - row, 0).astype(np.int64)
    edge = np.repeat(np.arange(len(count)), count)
    row = np.arange(len(edge)) + np.take(row - (np.cumsum(count) - count), edge)
    begin, end = np.maximum(row, np.take(low, edge)), np.minimum(row + 1, np.take(high, edge))
    slope, bottom, x = np.take(slope, edge), np.take(bottom, edge), np.take(x, edge)
    xa, xb = x + (begin - bottom) * slope, x + (end - bottom) * slope
    return edge, row.astype(np.int64), xa, xb, (end - begin) * np.take(np.where(up, 1.0, -1.0), edge)


def _add_narrow(cell, low, high, rise, deposits):
    """Deposits of pieces that reach from `low` < 1 to `high` <= 2 in the row that begins at their cell."""
    beyond = np.maximum(high - 1, 0)
    span = np.maximum(high - low, np.finfo(float).tiny)
    here = np.where(beyond > 0, (1 - low) ** 2 / span, 2 - low - high) / 2
    after = beyond * beyond / span / 2
    deposits.add(cell, rise * here)
    deposits.add(cell + 1, rise * (1 - here - after))
    some = np.flatnonzero(beyond)
    deposits.add(cell[some] + 2, rise[:, some] * after[some])


def _add_wide(cell, low, high, rise, deposits):
    """As `_add_narrow`, of pieces of any reach: a cell gets the second difference of the mean of max(c - x, 0)."""
    count = np.ceil(high).astype(np.int64) + 1
    piece = np.repeat(np.arange(len(cell)), count)
    rank = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)
    low, high = low[piece], high[piece]

    def mean_beyond(c):
        return (np.maximum(c - low, 0) ** 2 - np.maximum(c - high, 0) ** 2) / (2 * (high - low))

    share = mean_beyond(rank + 1) - 2 * mean_beyond(rank) + mean_beyond(rank - 1)
    deposits.add(cell[piece] + rank, rise[:, piece] * share)
