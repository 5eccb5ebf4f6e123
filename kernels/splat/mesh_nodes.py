"""Nodes of the water's own mesh: rays through its vertices and the middles of its edges, each cast once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import AFTER
from .lander import Nodes


@dataclass
class MeshNodes:
    """nodes: Nodes of all vertices (or corners, where normals jump) and then of the middles of all edges; corner (3,T)
    which nodes are at a triangle's corners; edge (3,T) the numbers of its edges, from corner k to the next; tail, head
    (E,) the nodes at an edge's ends; sign (3,T), 1 where the triangle runs along the edge, -1 where against it."""

    nodes: Nodes
    corner: np.ndarray
    edge: np.ndarray
    tail: np.ndarray
    head: np.ndarray
    sign: np.ndarray

    @classmethod
    def of(cls, lit, twins, lander, shadowed):
        """Those of a LitWater with twins (3T,), landed by a Lander; shadowed (T,) bool: look for shadows there."""
        half = np.arange(lit.triangles.size)
        if lit.triangles is lit.normal_triangles:
            corner, m, n = lit.triangles.astype(np.int64), lit.points.T, lit.shading.T
            owner = np.where((twins >= 0) & (twins < half), twins, half)  # of two half-edges the first has the node
        else:
            corner = half.reshape(-1, 3)
            m, n = lit.points[lit.triangles.ravel()].T, lit.shading[lit.normal_triangles.ravel()].T
            owner = half
        own = np.flatnonzero(owner == half)
        number = np.empty(len(half), np.int64)
        number[own] = np.arange(len(own))
        edge = np.take(number, owner)
        tails = corner.ravel()
        tail, head = np.take(tails, own), np.take(corner[:, AFTER].ravel(), own)
        sign = np.where(np.take(tail, edge) == tails, 1.0, -1.0)
        shade = np.zeros(m.shape[1] + len(own), bool)
        if shadowed.any():
            shaded = np.flatnonzero(np.repeat(shadowed, 3))
            shade[tails[shaded]] = shade[edge[shaded] + m.shape[1]] = True
        m, n = (np.concatenate([v, (np.take(v, tail, axis=1) + np.take(v, head, axis=1)) / 2], 1) for v in (m, n))
        by_row = (np.ascontiguousarray(v.reshape(-1, 3).T) for v in (corner, edge, sign))
        corner, edge, sign = by_row
        return cls(lander.land(m, n, shade), corner, edge, tail, head, sign)

    def clear(self, lander, shadowed, asked):
        """Whether (T,) nothing can hide between a triangle's rays, where asked (T,) bool, else True; shadowed (T,)
        bool: nor above the water there."""
        vertices = len(self.nodes.chart) - len(self.tail)
        clear, at = np.ones(len(shadowed), bool), np.flatnonzero(asked)
        if not lander.certain and len(at):
            m, n = self.nodes.m[:, :vertices], self.nodes.n[:, :vertices]
            clear[at] = lander.clear(m, n, self.corner.T[at], shadowed[at])
        return clear

    def six(self, index):
        """The nodes (6,n) at the corners, and the middles of the edges, of triangles index (n,)."""
        first = len(self.nodes.chart) - len(self.tail)
        return np.concatenate([self.corner[:, index], first + self.edge[:, index]])

    def bent(self):
        """How far [texel] (T,) each triangle's image is from affine; inf where its rays land on different charts."""
        a, b, middle = self.tail, self.head, slice(-len(self.tail), None)
        chart, x, y = self.nodes.chart, self.nodes.x, self.nodes.y
        off = np.maximum(
            np.abs(x[middle] - (np.take(x, a) + np.take(x, b)) / 2),
            np.abs(y[middle] - (np.take(y, a) + np.take(y, b)) / 2),
        )
        off[(np.take(chart, a) != chart[middle]) | (np.take(chart, b) != chart[middle])] = np.inf
        return np.maximum(np.maximum(*(np.take(off, e) for e in self.edge[:2])), np.take(off, self.edge[2]))
