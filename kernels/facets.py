"""What all lights ask of the water's triangles first: how large they are, how they lie, and to which side they look."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_BLOCK = 1 << 13  # triangles at once: what a block touches stays in the second-level cache


@dataclass(frozen=True)
class Facets:
    """across (3,T): vectors across triangles by their winding, twice their area long; leaning (3,T): the sums of the
    normals at their corners."""

    across: np.ndarray
    leaning: np.ndarray

    @classmethod
    def of(cls, positions, normals, triangles, normal_triangles):
        """Those of triangles (T,3) of positions (V,3), and normal_triangles (T,3) of normals (N,3)."""
        across, leaning = np.empty((2, 3, len(triangles)))
        m, n = (np.ascontiguousarray(v.T) for v in (positions, normals))
        for start in range(0, len(triangles), _BLOCK):
            block = slice(start, start + _BLOCK)
            corner = np.ascontiguousarray(triangles[block].T, np.intp)
            v = np.take(m, corner, axis=1)
            across[:, block] = cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
            if normal_triangles is not triangles:
                corner = np.ascontiguousarray(normal_triangles[block].T, np.intp)
            v = np.take(n, corner, axis=1)
            np.add(v[:, 0], v[:, 1], out=leaning[:, block])
            leaning[:, block] += v[:, 2]
        return cls(across, leaning)

    def outward(self):
        """The vectors across (3,T), on the side of the normals."""
        along = self.across[0] * self.leaning[0]
        for k in (1, 2):
            along += self.across[k] * self.leaning[k]
        return np.where(along < 0, -self.across, self.across)


def extents(points, triangles):
    """Least and greatest coordinates (k,T) of the corners of triangles (T,3) of points (V,k)."""
    corners = [np.ascontiguousarray(c, np.intp) for c in triangles.T]
    least, most = np.empty((2, points.shape[1], len(triangles)))
    for k, values in enumerate(np.ascontiguousarray(points.T)):
        a, b, c = (np.take(values, corner) for corner in corners)
        np.minimum(np.minimum(a, b, out=least[k]), c, out=least[k])
        np.maximum(np.maximum(a, b, out=most[k]), c, out=most[k])
    return least, most


def used(positions, triangles):
    """Those rows (n,3) of positions (V,3) that triangles (T,3) have as corners; without a sort."""
    some = np.zeros(len(positions), bool)
    some[triangles] = True
    return positions[some]


def cross(a, b):
    """Cross products (3,n) of vectors (3,n)."""
    across = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for k in range(3):
        across[k] = a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2]
    return across
