"""The positions texture: what receives light, as the light would see it straight through all that bends it [1].

[1] Shah, Konttinen & Pattanaik 2007, Caustics Mapping: III.B.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from .view import Raster


class Positions:
    """Points of Solids in the view of a light, on a Raster from `low` to `high` with `count` cells along it.

    start: None to look from the light on, or a function of rays (origins, directions) to where, beyond what bends the
    light, they are to begin.
    """

    def __init__(self, view, solids, low, high, count, start=None):
        self._view, self._raster = view, Raster(low, high, count)
        origin, direction = view.rays(self._raster.centres)
        if start is not None:
            origin = start(origin, direction)
        self._triangle = solids.first(origin, direction)
        hit = np.flatnonzero(self._triangle != MISS)
        self._point = np.full(origin.shape, np.nan)
        self._point[:, hit] = solids.meet(self._triangle[hit], origin[:, hit], direction[:, hit])[0]
        self._part = np.where(self._triangle != MISS, solids.part[self._triangle], MISS)

    def look_up(self, p):
        """Points (3,n) that the map holds where points p (3,n) are seen, or not numbers, and their triangles (n,), or
        MISS. Between cells of one surface they are interpolated. Off the map the points are those of its border."""
        own, nearest, around, share = self._raster.look_up(self._view.project(p))
        part, point = self._part[nearest], self._point[:, nearest]
        at = np.flatnonzero((self._part[around] == part).all(0) & (part != MISS))
        point[:, at] = sum(s[at] * self._point[:, a[at]] for s, a in zip(share, around, strict=True))
        return point, np.where(own < 0, MISS, self._triangle[nearest])
