"""Triangles in k x k parts each, alike on both sides of every edge.

The vertices of the parts are the old ones, then k - 1 on each edge, then those inside the triangles, (k - 1)(k - 2)/2
each. Corner (i, j) of the lattice in a triangle lies at its first corner + i/k of its first edge + j/k of its third.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..halfedges import AFTER


class Tessellation:
    """Triangles (T,3) with twins (3T,), each cut in k x k where `cut` (T,) bool says so; `count` old vertices.

    No cut triangle may share a vertex with an uncut one. triangles, twins: those of the parts, as in `Water`; ends
    (2,E): the old vertices of the cut edges; inner (3,S), edges (S,3): the corners and the edges of the cut triangles.
    """

    def __init__(self, triangles, twins, count, cut, k):
        self.k = k
        kept, cut = np.flatnonzero(~cut), np.flatnonzero(cut)
        self.inner = triangles[cut].T.astype(np.int64)
        self.edges, ahead, self.ends = _edges(triangles, twins, cut)
        table, halves, sides = _pattern(k)
        known = self._vertices(ahead, count)
        parts = known[:, table].reshape(-1, 3)
        self.triangles = np.concatenate([parts, triangles[kept]]).astype(triangles.dtype)
        self.twins = self._twins(triangles, twins, cut, kept, halves, sides)
        self.count = count + self.ends.shape[1] * (k - 1) + len(cut) * ((k - 1) * (k - 2) // 2)

    def shares(self):
        """The new vertices as combinations of the old: (2,k-1) of an edge's ends, (3,m) of a triangle's corners."""
        k, n = self.k, np.arange(1, self.k)
        i, j = _inside(k)
        return np.stack([k - n, n]) / k, np.stack([k - i - j, i, j]) / k

    def _vertices(self, ahead, count):
        """The vertices (S,m) of each cut triangle's lattice, in the order of `_pattern`."""
        k, size = self.k, len(self.edges)
        rank = np.arange(k - 1)
        along = count + self.edges[:, :, None] * (k - 1) + np.where(ahead[:, :, None], rank, rank[::-1])
        inside = (k - 1) * (k - 2) // 2
        first = count + self.ends.shape[1] * (k - 1)
        own = first + np.arange(size)[:, None] * inside + np.arange(inside)
        return np.concatenate([self.inner.T, along.reshape(size, -1), own], 1)

    def _twins(self, triangles, twins, cut, kept, halves, sides):
        """Twins of the parts: within a triangle by the pattern, across its edges piece by piece."""
        k, old = self.k, np.arange(triangles.size)
        size = 3 * k * k
        start = np.full(len(triangles), -1)  # first new half-edge of each old triangle
        start[cut] = np.arange(len(cut)) * size
        start[kept] = len(cut) * size + 3 * np.arange(len(kept))
        out = np.full(len(cut) * size + 3 * len(kept), -1, np.int32)
        inside = start[cut][:, None] + halves
        out[: len(cut) * size] = np.where(halves >= 0, inside, -1).ravel()
        flat = triangles.ravel()
        paired = twins >= 0
        one = old[paired & np.repeat(np.isin(np.arange(len(triangles)), cut), 3)]
        other = twins[one]
        along = flat[one] == flat[other]  # wound the other way round
        mine = start[one // 3][:, None] + sides[one % 3]
        theirs = sides[other % 3]
        theirs = start[other // 3][:, None] + np.where(along[:, None], theirs, theirs[:, ::-1])
        out[mine] = theirs
        one = old[paired & np.repeat(np.isin(np.arange(len(triangles)), kept), 3)]
        out[start[one // 3] + one % 3] = start[twins[one] // 3] + twins[one] % 3
        return out


def _edges(triangles, twins, cut):
    """Edges of triangles `cut`: number (S,3), whether (S,3) the triangle runs along it as it is stored, ends (2,E).

    Edges that have no twin, at the rim or where more than two triangles meet, are told by their vertices.
    """
    half = np.arange(triangles.size)
    owner = np.where(twins >= 0, np.minimum(half, twins), half)
    a, b = triangles.ravel().astype(np.int64), triangles[:, AFTER].ravel().astype(np.int64)
    alone = np.flatnonzero(twins < 0)
    keys = np.minimum(a[alone], b[alone]) * (int(a.max(initial=0)) + 1) + np.maximum(a[alone], b[alone])
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    owner[alone] = alone[first][which.ravel()]
    owner = owner.reshape(-1, 3)[cut]
    stored = np.zeros(len(half), bool)
    stored[owner] = True
    number = np.cumsum(stored) - 1
    kept = np.flatnonzero(stored)
    return number[owner], a[owner] == a.reshape(-1, 3)[cut], np.stack([a[kept], b[kept]])


def _inside(k):
    """i, j of the lattice's points inside a triangle, row by row."""
    points = [(i, j) for j in range(1, k) for i in range(1, k - j)]
    return np.array(points, int).reshape(-1, 2).T


def _pattern(k):
    """One triangle in k x k parts: their corners (k*k,3) among its points (corners, points on the edges, points
    inside); the half-edge (3*k*k,) across each, -1 on its sides; and the half-edges (3,k) along its three sides."""
    number = {(0, 0): 0, (k, 0): 1, (0, k): 2}
    for n in range(1, k):
        for edge, point in enumerate(((n, 0), (k - n, n), (0, k - n))):
            number[point] = 3 + edge * (k - 1) + n - 1
    for n, point in enumerate(_inside(k).T.tolist()):
        number[tuple(point)] = 3 + 3 * (k - 1) + n
    parts = []
    for j in range(k):
        for i in range(k - j):
            parts.append([number[i, j], number[i + 1, j], number[i, j + 1]])
            if i + j < k - 1:
                parts.append([number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]])
    table = np.array(parts)
    over = {(a, b): h for h, (a, b) in enumerate(zip(table.ravel(), table[:, AFTER].ravel()))}
    across = np.array([over.get((b, a), -1) for a, b in over])
    corners = [[(n, 0) for n in range(k + 1)], [(k - n, n) for n in range(k + 1)], [(0, k - n) for n in range(k + 1)]]
    sides = [[over[number[p], number[q]] for p, q in pairwise(line)] for line in corners]
    return table, across, np.array(sides)
