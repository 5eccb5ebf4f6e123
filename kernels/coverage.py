"""Exact area coverage: how much of each texel lies inside polygons, by Green's theorem on their edges.

An edge is cut at the grid's lines. A piece inside the cell (i, j), of height dy and mean fractional abscissa f, covers
dy (1 - f) of its cell to its right and dy of every cell further right; so it deposits dy (1 - f) at i and dy f at
i + 1, and a cumulative sum along x turns the deposits into areas. Exact up to float64 rounding, for any polygons.
"""

from __future__ import annotations

import numpy as np

_BLOCK = 1 << 20  # pieces at once: bounds the memory


def edge_coverage(starts, ends, weights, shape):
    """Weighted area that the polygons bounded by directed edges cover in every cell.

    starts, ends (n,2): edges in texel units, x in [0, W], y in [0, H], counter-clockwise round what is covered;
    weights (n,): density of each edge's polygon; shape (H, W). Returns (H, W) float64.
    Raises ValueError where an edge leaves the grid.
    """
    height, width = shape
    limit = np.array([width, height], float)
    for name, points in (("starts", starts), ("ends", ends)):
        if len(points) and (points.min() < 0 or (points > limit).any()):
            raise ValueError(f"{name} must lie in [0, {width}] x [0, {height}], got {points.min(0)} to {points.max(0)}")
    deposits = np.zeros((height, width + 2))
    rows = np.abs(np.floor(ends[:, 1]) - np.floor(starts[:, 1])) + 1
    for block in _blocks(rows):
        _deposit(starts[block], ends[block], weights[block], deposits)
    return np.cumsum(deposits, axis=1)[:, :width]


def _blocks(pieces):
    """Slices of consecutive edges of about _BLOCK pieces each."""
    total = np.cumsum(pieces)
    cuts = np.searchsorted(total, np.arange(_BLOCK, total[-1] if len(total) else 0, _BLOCK)) + 1
    return [slice(a, b) for a, b in zip([0, *cuts], [*cuts, len(pieces)], strict=True) if b > a]


def _cut(starts, ends, axis):
    """Cut edges at the integer lines of one axis: (parent edge, starts, ends) of the pieces, in order."""
    low = np.floor(np.minimum(starts[:, axis], ends[:, axis]))
    high = np.ceil(np.maximum(starts[:, axis], ends[:, axis]))
    count = np.maximum(high - low, 1).astype(np.int64)
    parent = np.repeat(np.arange(len(starts)), count)
    rank = np.arange(len(parent)) - np.repeat(np.cumsum(count) - count, count)
    a, b = starts[parent], ends[parent]
    span = b[:, axis] - a[:, axis]
    up = span >= 0
    first = np.where(up, low[parent] + rank, low[parent] + count[parent] - rank)  # the line that a piece starts at
    safe = np.where(span == 0, 1.0, span)
    s0 = np.where(rank == 0, 0.0, (first - a[:, axis]) / safe)
    s1 = np.where(rank == count[parent] - 1, 1.0, (first + np.where(up, 1, -1) - a[:, axis]) / safe)
    delta = b - a
    return parent, a + s0[:, None] * delta, np.where((s1 == 1.0)[:, None], b, a + s1[:, None] * delta)


def _deposit(starts, ends, weights, deposits):
    """Add the deposits of one block of edges."""
    height, width = deposits.shape
    slanted = starts[:, 1] != ends[:, 1]  # level edges bound no area to their right
    row, a, b = _cut(starts[slanted], ends[slanted], axis=1)
    piece, a, b = _cut(a, b, axis=0)
    middle = (a + b) / 2
    i = np.clip(np.floor(middle[:, 0]), 0, width - 2).astype(np.int64)
    j = np.clip(np.floor(middle[:, 1]), 0, height - 1).astype(np.int64)
    # Counter-clockwise, what is covered lies left of an upward edge, hence the sign.
    w = -weights[slanted][row[piece]] * (b[:, 1] - a[:, 1])
    f = middle[:, 0] - i
    cell = j * width + i
    flat = deposits.reshape(-1)
    flat += np.bincount(cell, w * (1 - f), minlength=flat.size)
    flat += np.bincount(cell + 1, w * f, minlength=flat.size)
