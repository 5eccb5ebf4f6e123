"""Exact area coverage: how much of each texel lies inside polygons, by Green's theorem on their edges.

An edge is cut at the grid's lines. A piece inside the cell (i, j), of height dy and mean fractional abscissa f, covers
dy (1 - f) of its cell to its right and dy of every cell further right; so it deposits dy (1 - f) at i and dy f at
i + 1, and a cumulative sum along x turns the deposits into areas. Exact up to float64 rounding, for any polygons.
"""

from __future__ import annotations

import numpy as np

_BLOCK = 1 << 15  # edges at once: bounds the memory


def edge_coverage(starts, ends, weights, shape):
    """Weighted area that the polygons bounded by directed edges cover in every cell.

    starts, ends (2,n): x, y of edges in texel units, x in [0, W], y in [0, H], counter-clockwise round what is covered;
    weights (n,): density of each edge's polygon; shape (H, W). Returns (H, W) float64.
    Raises ValueError where an edge leaves the grid.
    """
    height, width = shape
    for name, points in (("starts", starts), ("ends", ends)):
        if points.size and (points.min() < 0 or points[0].max() > width or points[1].max() > height):
            low, high = points.min(1), points.max(1)
            raise ValueError(f"{name} must lie in [0, {width}] x [0, {height}], got {low} to {high}")
    deposits = np.zeros(height * (width + 2))
    for k in range(0, len(weights), _BLOCK):
        block = slice(k, k + _BLOCK)
        _deposit(starts[:, block], ends[:, block], weights[block], shape, deposits)
    return np.cumsum(deposits.reshape(height, width + 2), axis=1)[:, :width]


def _cut(u0, u1, cells):
    """Cut spans from u0 to u1 (n,) at the integers: per piece its parent, its cell (below `cells`), and the shares of
    the parent at which it begins and ends."""
    low = np.floor(np.minimum(u0, u1))
    count = np.maximum(np.ceil(np.maximum(u0, u1)) - low, 1).astype(np.int64)
    parent = np.repeat(np.arange(len(u0)), count)
    rank = np.arange(len(parent)) - np.repeat(np.cumsum(count) - count, count)
    span = u1 - u0
    down = span < 0  # pieces run with the span: from its lowest line up, or from its highest down
    rate = 1 / np.where(span == 0, 1.0, span)
    line = low + np.where(down, count, 0)
    first, advance = ((line - u0) * rate)[parent], np.abs(rate)[parent]
    begin = np.where(rank == 0, 0.0, first + rank * advance)
    end = np.where(rank == (count - 1)[parent], 1.0, first + (rank + 1) * advance)
    cell = line[parent] + np.where(down[parent], -1 - rank, rank)
    return parent, np.minimum(cell, cells - 1).astype(np.int64), begin, end


def _deposit(starts, ends, weights, shape, deposits):
    """Add the deposits of one block of edges."""
    height, width = shape
    (x0, y0), (x1, y1) = starts, ends
    slanted = np.flatnonzero(y0 != y1)  # level edges bound no area to their right
    x0, y0, x1, y1 = x0[slanted], y0[slanted], x1[slanted], y1[slanted]
    edge, row, begin, end = _cut(y0, y1, height)
    # Counter-clockwise, what is covered lies left of an upward edge, hence the sign.
    rise = (-weights[slanted] * (y1 - y0))[edge] * (end - begin)
    xa, dx = x0[edge], (x1 - x0)[edge]
    xb, xa = xa + dx * end, xa + dx * begin
    piece, column, begin, end = _cut(xa, xb, width)
    rise = rise[piece] * (end - begin)
    f = xa[piece] + (xb - xa)[piece] * ((begin + end) / 2) - column
    cell = row[piece] * (width + 2) + column
    deposits += np.bincount(cell, rise * (1 - f), minlength=len(deposits))
    deposits += np.bincount(cell + 1, rise * f, minlength=len(deposits))
