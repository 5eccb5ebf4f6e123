"""The lit water as the tables that walks and searches for paths read."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..halfedges import AFTER, BEFORE


class Surface:
    """The lit water as tables that a walk reads: one row per corner record, one entry per half-edge.

    m (3,R) positions and n (3,R) normals of the records, which are the vertices under smooth shading and the corners of
    the triangles otherwise. Per half-edge (3T,): tail and head, the records of its ends; over, its twin; turned, bool
    or None, the twin runs the same way. smooth: both sides of an edge share their records; area (T,) as of LitWater;
    lamp, the position (3,) of a light that is near, or None.
    """

    def __init__(self, lit, twins):
        flat = lit.triangles.ravel()
        self._frame, self._source, self.area = lit.frame, lit.source, lit.area
        self.lamp = lit.frame @ lit.source.position if lit.source.varies else None
        if lit.normal_triangles is lit.triangles or np.array_equal(lit.normal_triangles, lit.triangles):
            record, self.m, self.n, self.smooth = flat, lit.positions.T, lit.normals.T, True
        else:
            record, self.smooth = np.arange(len(flat)), False
            self.m, self.n = lit.positions[flat].T, lit.normals[lit.normal_triangles.ravel()].T
        self.m, self.n = np.ascontiguousarray(self.m), np.ascontiguousarray(self.n)
        corner = record.reshape(-1, 3).astype(np.int64)
        self.tail = corner.ravel()
        self.head = corner[:, AFTER].ravel()
        self.over = twins.astype(np.int64)
        turned = (self.over >= 0) & (flat[self.over] == flat)
        self.turned = turned if turned.any() else None

    @cached_property
    def shared(self):
        """Whether (3T,) the twin of a half-edge lies between the same records, from its head to its tail."""
        over = self.over
        return (over >= 0) & (self.tail.take(over) == self.head) & (self.head.take(over) == self.tail)

    @cached_property
    def k(self):
        """k (3T,) of the edges, see `conic.py`."""
        dn, dm = ([np.take(c, self.head) - np.take(c, self.tail) for c in table[:2]] for table in (self.n, self.m))
        return dn[0] * dm[1] - dn[1] * dm[0]

    @cached_property
    def plan(self):
        """m_x, m_y, n_x and n_y (R,4) of the records: what g needs, in half a line of the cache."""
        return np.stack([*self.m[:2], *self.n[:2]], 1)

    @cached_property
    def rise(self):
        """m_z and n_z (R,2) of the records."""
        return np.stack([self.m[2], self.n[2]], 1)

    @cached_property
    def ways(self):
        """What a step from each half-edge needs of its triangle, a quarter of a line of the cache (3T,4) int32: the
        record across; the twins of the triangle's edge after it and before it; and, as float32, no less than |k| of
        both."""
        half = np.arange(len(self.tail)).reshape(-1, 3)
        after, before = half[:, AFTER].ravel(), half[:, BEFORE].ravel()
        most = np.maximum(np.abs(self.k)[after], np.abs(self.k)[before]).astype(np.float32)
        bound = np.nextafter(most, np.float32(np.inf)).view(np.int32)
        return np.stack([self.tail[before], self.over[after], self.over[before], bound], 1).astype(np.int32)

    def arriving(self, points):
        """Unit direction (3,n) or (3,1) of the light at points (3,n)."""
        return -(self._frame @ self._source.incident(self._frame.T @ points)[0])

    def met(self, points):
        """What points (3,n) meet, (n,) or 1, of the light's power; see `sources`."""
        return self._source.incident(self._frame.T @ points)[2]

    def g(self, record, px, py):
        """g (n,) at records for receiver points (px, py)."""
        return g_at(self.plan.take(record, axis=0), px, py)

    def g_at_ends(self, half_edge, p):
        """g (2,n) at the tail and the head of half-edges (n,) for receiver points p (3,n)."""
        return np.stack([self.g(np.take(r, half_edge), p[0], p[1]) for r in (self.tail, self.head)])

    def g_at_corners(self, triangle, px, py):
        """g (n,3) at the corners of triangles (n,)."""
        return np.stack([self.g(record, px, py) for record in self.corner_records(triangle).T], 1)

    def corner_records(self, triangle):
        """Records (n,3) of the corners of triangles (n,)."""
        return self.tail.reshape(-1, 3)[triangle]

    def corners(self, triangle):
        """Positions and normals (3,3,n), as corner, axis, triangle, of the corners of triangles (n,)."""
        record = np.ascontiguousarray(self.corner_records(triangle).T)
        return tuple(np.stack([np.take(c, record) for c in table], 1) for table in (self.m, self.n))

    def at(self, triangle, weights):
        """M (3,n) and N (3,n) at barycentric weights (n,3) of triangles (n,)."""
        first, second, third = np.ascontiguousarray(self.corner_records(triangle).T)
        one, two, three = np.ascontiguousarray(weights.T)
        return [
            [one * c.take(first) + two * c.take(second) + three * c.take(third) for c in table]
            for table in (self.m, self.n)
        ]


def g_at(plan, px, py):
    """g (n,) at rows (n,4) of `Surface.plan` for receiver points (px, py)."""
    return plan[:, 2] * (plan[:, 1] - py) - plan[:, 3] * (plan[:, 0] - px)
