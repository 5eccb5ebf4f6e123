"""Where rays that end on receivers arrive: at which chart and which texel coordinates."""

from __future__ import annotations

import numpy as np

from ..optics import dot
from ..splat.lander import texel_maps


class Arrivals:
    """Receivers of a Scene with their Texels, all of one resolution.

    Charts are numbered through all receivers; image (charts,) is the receiver that each belongs to.
    """

    def __init__(self, receivers, texels):
        maps = [texel_maps(r, t.resolution) for r, t in zip(receivers, texels, strict=True)]
        self._maps = np.concatenate([np.zeros((0, 3, 4)), *maps]).reshape(-1, 12).T.copy()
        counts = [t.chart.max(initial=-1) + 1 for t in texels]
        bases = np.cumsum([0, *counts])
        self._charts = np.concatenate([np.zeros(0, np.int64), *(t.chart + b for t, b in zip(texels, bases))])
        self.image = np.repeat(np.arange(len(texels)), counts)
        self.side = max((t.resolution for t in texels), default=0)

    def at(self, triangle, origin, direction):
        """Chart (k,), texel coordinates x, y (k,) in [0, side], distance (k,) [m] and cosine (k,) of incidence where
        rays meet triangles (k,) of receivers."""
        height, x, y = (np.take(self._maps[4 * k : 4 * k + 4], triangle, axis=1) for k in range(3))
        fall = dot(height, direction)
        with np.errstate(divide="ignore", invalid="ignore"):  # a surface exactly along the ray
            distance = -(dot(height, origin) + height[3]) / fall
        distance = np.where(np.isfinite(distance), np.maximum(distance, 0), 0.0)
        point = origin + distance * direction
        x, y = (np.clip(dot(v, point) + v[3], 0, self.side) for v in (x, y))
        return np.take(self._charts, triangle), x, y, distance, np.abs(fall)
