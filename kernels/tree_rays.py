"""A ray tracer in numpy, for where embreex has no wheel or does not load: the same answers, some twenty times slower.

Triangles lie in the order of a curve that fills space [1], in the leaves of a complete binary tree. Rays go down it a
level at a time, all pairs of a ray and a box that it pierces at once.

[1] Morton 1966, A computer oriented geodetic data base and a new technique in file sequencing.
"""

from __future__ import annotations

import numpy as np

MISS = -1
_LEAF = 4  # triangles
_BLOCK = 1 << 12  # rays at once: their pairs stay in the cache
_BITS = 10  # of the curve, along each axis
_EDGE = 1e-7  # in barycentric coordinates: rays through a shared edge meet one of its triangles at least
_WIDER = 1e-7  # of the extent: boxes are wider by so much than what they hold, for rounding


class TreeScene:
    """Triangles (T,3) into vertices (V,3), answering as `embreex.rtcore_scene.EmbreeScene` does."""

    def __init__(self, vertices, triangles):
        corners = np.asarray(vertices, float)[triangles]
        order = _along_curve(corners.mean(1))
        self._depth = max(int(np.ceil(np.log2(max(len(order) / _LEAF, 1)))), 0)
        slots = np.full(_LEAF << self._depth, MISS)
        slots[: len(order)] = order
        self._slots = slots.reshape(-1, _LEAF)
        self._first = corners[:, 0].T.copy()
        self._edge1, self._edge2 = (corners[:, k].T - self._first for k in (1, 2))
        self._levels = _boxes(corners, self._slots, _WIDER * np.ptp(corners, axis=(0, 1)).max())

    def run(self, origins, directions, dists=None, query="INTERSECT"):
        """Index (n,) of the first triangle that rays (n,3) meet, MISS for none; for query "OCCLUDED" of any triangle
        within `dists` (n,)."""
        origins, directions = np.asarray(origins, float), np.asarray(directions, float)
        far = np.full(len(origins), np.inf) if dists is None else np.asarray(dists, float)
        hit = np.full(len(origins), MISS, np.int32)
        for start in range(0, len(origins), _BLOCK):
            own = slice(start, start + _BLOCK)
            hit[own] = self._run(origins[own].T.copy(), directions[own].T.copy(), far[own], query == "OCCLUDED")
        return hit

    def _run(self, origin, direction, far, any_hit):
        """As `run`, of one block of rays (3,n)."""
        with np.errstate(divide="ignore"):
            inverse = 1 / direction
        ray, node = np.arange(origin.shape[1]), np.zeros(origin.shape[1], np.int64)
        for low, high in self._levels:
            ray, node = _pierced(low, high, origin, inverse, far, ray, node)
            last = low.shape[1] == len(self._slots)
            if not last:
                ray, node = np.repeat(ray, 2), (2 * node[:, None] + [0, 1]).ravel()
        ray, triangle = np.repeat(ray, _LEAF), self._slots[node].ravel()
        there = triangle != MISS
        return self._nearest(origin, direction, far, ray[there], triangle[there], any_hit)

    def _nearest(self, origin, direction, far, ray, triangle, any_hit):
        """The first triangle (n,) that each ray meets, of pairs (k,) of a ray and a triangle; see [2].

        [2] Moeller & Trumbore 1997, Fast, minimum storage ray/triangle intersection.
        """
        o, d = origin[:, ray], direction[:, ray]
        e1, e2 = self._edge1[:, triangle], self._edge2[:, triangle]
        p = _cross(d, e2)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / (e1 * p).sum(0)
            s = o - self._first[:, triangle]
            u = (s * p).sum(0) * inverse
            q = _cross(s, e1)
            v, t = (d * q).sum(0) * inverse, (e2 * q).sum(0) * inverse
            met = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (t >= 0) & (t <= far[ray])
        ray, triangle, t = ray[met], triangle[met], t[met]
        order = np.arange(len(t)) if any_hit else np.lexsort((triangle, -t, ray))
        hit = np.full(origin.shape[1], MISS, np.int32)
        hit[ray[order]] = triangle[order]  # the last of a ray's stays: its nearest
        return hit


def _pierced(low, high, origin, inverse, far, ray, node):
    """Those pairs (k,) of a ray and a box, of boxes low and high (3,m), in which the ray pierces the box."""
    near, end = np.zeros(len(ray)), far[ray]
    with np.errstate(invalid="ignore"):  # 0 * inf, where a ray runs in the plane of a side: fmin and fmax pass over it
        for axis in range(3):
            o, i = origin[axis, ray], inverse[axis, ray]
            a, b = (low[axis, node] - o) * i, (high[axis, node] - o) * i
            near = np.fmax(near, np.fmin(a, b))
            end = np.fmin(end, np.fmax(a, b))
    kept = near <= end
    return ray[kept], node[kept]


def _boxes(corners, slots, wider):
    """[(low, high)] (3,nodes) of the levels of the tree, the root's first, over leaves (L,_LEAF) of triangles."""
    full = np.where((slots != MISS)[:, :, None, None], corners[slots], np.nan).reshape(len(slots), -1, 3)
    with np.errstate(invalid="ignore"):
        low = np.fmin.reduce(full, axis=1).T - wider
        high = np.fmax.reduce(full, axis=1).T + wider
    levels = [(low, high)]
    while levels[0][0].shape[1] > 1:
        low, high = levels[0]
        levels.insert(0, (np.fmin(low[:, ::2], low[:, 1::2]), np.fmax(high[:, ::2], high[:, 1::2])))
    return [(np.nan_to_num(low, nan=np.inf), np.nan_to_num(high, nan=-np.inf)) for low, high in levels]


def _along_curve(middles):
    """The order (T,) of points (T,3) along Morton's curve."""
    low, size = middles.min(0), np.maximum(np.ptp(middles, axis=0).max(), np.finfo(float).tiny)
    cells = np.minimum((middles - low) / size * (1 << _BITS), (1 << _BITS) - 1).astype(np.int64)
    code = np.zeros(len(middles), np.int64)
    for bit in range(_BITS):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")


def _cross(a, b):
    """Cross products (3,k)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
