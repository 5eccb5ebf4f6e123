"""Nodes of the water's own mesh: rays through its vertices and the middles of its edges, each cast once."""

from __future__ import annotations

import numpy as np

from .lander import Nodes

_BLOCK = 1 << 13  # nodes at once: what a block touches stays in the second-level cache


class MeshNodes:
    """Where rays land through all vertices (or corners, where normals jump) and then through the middles of all edges
    of a LitWater with its Edges, by a Lander; shadowed (T,) bool: look for shadows there.

    chart, x, y, spread and carried are as of `lander.Nodes`.
    """

    def __init__(self, lit, edges, lander, shadowed):
        self.edges = edges
        if edges.smooth:
            self._m, self._n = (np.ascontiguousarray(v.T) for v in (lit.points, lit.shading))
        else:
            rows = (lit.points[lit.triangles.ravel()], lit.shading[lit.normal_triangles.ravel()])
            self._m, self._n = (np.ascontiguousarray(v.T) for v in rows)
        self.vertices = self._m.shape[1]
        count = self.vertices + len(edges.tail)
        shade = np.zeros(count, bool)
        if shadowed.any():
            shade[edges.corner[:, shadowed]] = shade[edges.edge[:, shadowed] + self.vertices] = True
        self.chart, self.x, self.y, self.spread = np.empty(count, np.int64), *np.empty((3, count))
        self.carried = np.empty((lander.rows.total, count))
        for start in range(0, self.vertices, _BLOCK):
            block = slice(start, min(start + _BLOCK, self.vertices))
            self._keep(block, lander.land(self._m[:, block], self._n[:, block], shade[block]))
        for start in range(0, len(edges.tail), _BLOCK):
            block = slice(start, start + _BLOCK)
            own = slice(start + self.vertices, min(start + _BLOCK + self.vertices, count))
            self._keep(own, lander.land(*self._middles(block), shade[own]))

    def _keep(self, block, landed):
        """Keep the Nodes of a block."""
        self.chart[block], self.x[block], self.y[block] = landed.chart, landed.x, landed.y
        self.spread[block], self.carried[:, block] = landed.spread, landed.carried

    def _middles(self, edges):
        """Positions and normals (3,n) in the middles of edges (n,)."""
        tail, head = self.edges.tail[edges], self.edges.head[edges]
        return ((np.take(v, tail, axis=1) + np.take(v, head, axis=1)) / 2 for v in (self._m, self._n))

    def clear(self, lander, shadowed, asked):
        """Whether (T,) nothing can hide between a triangle's rays, where asked (T,) bool, else True; shadowed (T,)
        bool: nor above the water there."""
        clear, at = np.ones(len(shadowed), bool), np.flatnonzero(asked)
        if not lander.certain and len(at):
            clear[at] = lander.clear(self._m, self._n, self.edges.corner.T[at], shadowed[at])
        return clear

    def six(self, index):
        """The nodes (6,n) at the corners, and the middles of the edges, of triangles index (n,)."""
        return np.concatenate([self.edges.corner[:, index], self.vertices + self.edges.edge[:, index]])

    def part(self, index):
        """Nodes of triangles index (n,) alone, and which of them (6,n) are at their corners and middles."""
        six = self.six(index)
        flat = six.ravel()
        corners, edges = self.edges.corner[:, index].ravel(), self.edges.edge[:, index].ravel()
        middles = self._middles(edges)
        m, n = (np.concatenate([np.take(v, corners, axis=1), w], 1) for v, w in zip((self._m, self._n), middles))
        kept = (np.take(v, flat, axis=-1) for v in (self.chart, self.x, self.y, self.spread, self.carried))
        return Nodes(m, n, *kept), np.arange(len(flat)).reshape(six.shape)

    def bent(self):
        """How far [texel] (T,) each triangle's image is from affine; inf where its rays land on different charts."""
        a, b, middle = self.edges.tail, self.edges.head, slice(self.vertices, None)
        chart, x, y = self.chart, self.x, self.y
        off = np.maximum(
            np.abs(x[middle] - (np.take(x, a) + np.take(x, b)) / 2),
            np.abs(y[middle] - (np.take(y, a) + np.take(y, b)) / 2),
        )
        off[(np.take(chart, a) != chart[middle]) | (np.take(chart, b) != chart[middle])] = np.inf
        first, second, third = (np.take(off, edge) for edge in self.edges.edge)
        return np.maximum(np.maximum(first, second), third)
