"""A proof that no path is missing: the signed count of paths to a point is the winding number of the rim's image.

By degree theory the triangles whose image covers a point, +1 or -1 as the image is turned, sum to the number of times
that the image of the water's rim winds round the point: 1 under wide water, 0 beyond. One path missed or counted twice
breaks the sum. The winding number is counted along the rows of the grid of `candidates.py`, once for each cell that the
rim's image does not pass: nothing is claimed of the cells that it passes, nor of points among the waves.
"""

from __future__ import annotations

import numpy as np

from ..halfedges import AFTER
from .candidates import at_depth

_PARTS = 8  # straight parts that a rim edge's image is taken as
_UNKNOWN = np.iinfo(np.int64).min


def whole_triangles(surface, triangles):
    """Of triangles (m,), those whose normals face the light everywhere, in which every path counts."""
    light = (surface.arriving(surface.m) * surface.n).sum(0)
    return triangles[(light[surface.corner_records(triangles)] < 0).all(1)]


def missing(surface, grid, triangles, roots, turn, count):
    """Whether (n,) the paths to each of n = `count` points are proven to be too few or too many.

    triangles (m,): of `whole_triangles`; roots: all Roots; turn (r,) the sign of the image at each.
    """
    expected = _winding(surface, grid, triangles)[grid.cell]
    counts = np.zeros(len(surface.over) // 3, bool)
    counts[triangles] = True
    own = counts[roots.triangle]
    found = np.bincount(roots.point[own], turn[own], minlength=count).astype(np.int64)
    lowest = grid.depth_of(surface.m).max(initial=-np.inf)
    under = np.empty(count, bool)
    under[grid.order] = grid.depth > lowest
    return under & (expected != _UNKNOWN) & (found != expected)


def _rim(surface, triangles):
    """Half-edges of triangles (m,) across which none of them goes on, or not with the same normals."""
    domain = np.zeros(len(surface.over) // 3, bool)
    domain[triangles] = True
    half = (3 * triangles[:, None] + np.arange(3)).ravel()
    over = surface.over[half]
    inside = (over >= 0) & domain[over // 3]
    other = np.flatnonzero(inside & ~surface.shared[half])  # other records may hold the same
    tail, head = surface.tail[half[other]], surface.head[half[other]]
    across_tail, across_head = surface.head[over[other]], surface.tail[over[other]]
    for table in (surface.m, surface.n):
        for c in table:
            inside[other] &= (c[tail] == c[across_tail]) & (c[head] == c[across_head])
    return half[~inside]


def _winding(surface, grid, triangles):
    """Winding number of the rim's image round each cell (layers * rows * columns,), _UNKNOWN where it passes."""
    half = _rim(surface, triangles)
    triangle, edge = np.divmod(half, 3)
    corner = grid.rays.corner
    lines = grid.lines(corner[triangle, edge], corner[triangle, AFTER[edge]], grid.rays.middle[triangle, edge])
    winding = np.empty(grid.shape, np.int64)
    for layer, (top, bottom) in enumerate(zip(*grid.ends, strict=True)):
        ends = [at_depth(lines, depth) for depth in {top, bottom}]
        turns = _scan(grid, at_depth(lines, (top + bottom) / 2))
        winding[layer] = np.where(_passed(grid, ends), _UNKNOWN, turns)
    return winding.ravel()


def _scan(grid, image):
    """Winding numbers (rows, columns) round the cells' centres, by the edges that cross each row to the left."""
    _, rows, columns = grid.shape
    u, v = (_curve(*c) for c in image)
    u, v = (u - grid.low[0]) / grid.size - 0.5, (v - grid.low[1]) / grid.size - 0.5
    u0, u1, v0, v1 = (c.ravel() for c in (u[:-1], u[1:], v[:-1], v[1:]))
    first = np.clip(np.ceil(np.minimum(v0, v1)), 0, rows)
    count = (np.clip(np.ceil(np.maximum(v0, v1)), 0, rows) - first).astype(np.int64)
    own = np.repeat(np.arange(len(u0)), count)
    row = np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first.astype(np.int64), count)
    across = u0[own] + (row - v0[own]) / (v1 - v0)[own] * (u1 - u0)[own]
    column = np.clip(np.ceil(across), 0, columns).astype(np.int64)
    sign = np.where(v1 > v0, -1.0, 1.0)[own]  # counter-clockwise, what is enclosed lies left of a rising edge
    steps = np.bincount(row * (columns + 1) + column, sign, minlength=rows * (columns + 1))
    return np.cumsum(steps.reshape(rows, columns + 1), axis=1)[:, :columns].astype(np.int64)


def _curve(tail, head, middle):
    """Values (_PARTS + 1, n) along edges with values tail, head and middle (n,)."""
    s = np.linspace(0, 1, _PARTS + 1)[:, None]
    return tail * (1 - s) * (1 - 2 * s) + head * s * (2 * s - 1) + 4 * middle * s * (1 - s)


def _passed(grid, ends):
    """Whether (rows, columns) cells may be passed by edges with images `ends` at the top and bottom of a layer."""
    _, rows, columns = grid.shape
    boxes = []
    for c, low in zip(zip(*ends, strict=True), grid.low, strict=True):
        points = np.stack([p for tail, head, middle in c for p in (tail, head, 2 * middle - (tail + head) / 2)])
        boxes.append((np.floor((points.min(0) - low) / grid.size), np.floor((points.max(0) - low) / grid.size)))
    (u0, u1), (v0, v1) = boxes
    seen = (u1 >= 0) & (u0 < columns) & (v1 >= 0) & (v0 < rows)
    u0, v0 = (np.maximum(c[seen], 0).astype(np.int64) for c in (u0, v0))
    u1, v1 = (np.minimum(c[seen], top - 1).astype(np.int64) + 1 for c, top in ((u1, columns), (v1, rows)))
    marks = np.zeros((rows + 1, columns + 1), np.int64)
    for v, u, sign in ((v0, u0, 1), (v1, u1, 1), (v0, u1, -1), (v1, u0, -1)):
        np.add.at(marks, (v, u), sign)
    return marks.cumsum(0).cumsum(1)[:rows, :columns] > 0
