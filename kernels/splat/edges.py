"""The water's edges, each once: between which triangles and nodes it lies. The same for all lights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import AFTER


@dataclass(frozen=True)
class Edges:
    """smooth: the nodes are the vertices, else, where normals jump, the corners of the triangles.

    corner (3,T): which nodes are at a triangle's corners; edge (3,T): the numbers of its edges, from corner k to the
    next; tail, head (E,): the nodes at an edge's ends; left, right (E,): the triangles along it, T for none; turned
    (E,): 1 where the right one runs along the edge as the left one does, since one is wound against the other, else
    -1.
    """

    smooth: bool
    corner: np.ndarray
    edge: np.ndarray
    tail: np.ndarray
    head: np.ndarray
    left: np.ndarray
    right: np.ndarray
    turned: np.ndarray

    @classmethod
    def of(cls, triangles, twins, smooth):
        """Those of triangles (T,3) with twins (3T,)."""
        half = np.arange(triangles.size)
        tails = np.ascontiguousarray(triangles if smooth else half.reshape(-1, 3), np.intp).ravel()
        if smooth:
            first = (twins < 0) | (twins > half)  # of two half-edges the first makes the edge
            number = np.cumsum(first) - 1
            edge = np.where(first, number, np.take(number, twins))
            own = np.flatnonzero(first)
            across = np.take(twins, own).astype(np.intp)
        else:
            own, edge, across = half, half, np.full(len(half), -1)
        corner = tails.reshape(-1, 3)
        tail, head = np.take(tails, own), np.take(corner[:, AFTER].ravel(), own)
        turned = np.where((np.take(tails, across) == tail) & (across >= 0), 1.0, -1.0)
        right = np.where(across < 0, len(triangles), across // 3)
        by_row = (np.ascontiguousarray(v.reshape(-1, 3).T) for v in (corner, edge))
        return cls(smooth, *by_row, tail, head, own // 3, right, turned)

    def differences(self, density):
        """What lies left of each edge more than right of it (C,E), of densities (C,T) of triangles."""
        padded = np.concatenate([density, np.zeros((len(density), 1))], 1)
        return np.take(padded, self.left, axis=1) + self.turned * np.take(padded, self.right, axis=1)
