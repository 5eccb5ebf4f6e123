"""Where rays that end on receivers arrive: at which chart and which texel coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..optics import dot
from ..splat.lander import BACK, texel_maps
from .picks import chosen, indices, pick


@dataclass
class Landed:
    """Rays on receivers: ray (k,), which it is of those that ended; photon and path (k,), see `follow.Rays`; chart
    (k,), or BACK of a triangle; x, y (k,) texel coordinates; colour (C,k) of what arrives; way (k,) [m] all the way
    there."""

    ray: np.ndarray
    photon: np.ndarray
    path: np.ndarray
    chart: np.ndarray
    x: np.ndarray
    y: np.ndarray
    colour: np.ndarray
    way: np.ndarray

    def take(self, index):
        return Landed(*(pick(a, index) for a in vars(self).values()))


class Arrivals:
    """Receivers of a Scene with their Texels, all of one resolution, among Surfaces.

    Charts are numbered through all receivers; image (charts,) is the receiver that each belongs to, box (2,2,charts)
    [texel] the least and the most x and y of each.
    """

    def __init__(self, receivers, texels, surfaces):
        maps = [texel_maps(r, t.resolution) for r, t in zip(receivers, texels, strict=True)]
        self._maps = np.concatenate([np.zeros((0, 3, 4)), *maps]).reshape(-1, 12).T.copy()
        counts = [t.chart.max(initial=-1) + 1 for t in texels]
        bases = np.cumsum([0, *counts])
        self._charts = np.concatenate([np.zeros(0, np.int64), *(t.chart + b for t, b in zip(texels, bases))])
        self.image = np.repeat(np.arange(len(texels)), counts)
        self.side = max((t.resolution for t in texels), default=0)
        self.box = _boxes(receivers, self._charts, len(self.image), self.side)
        self._surfaces = surfaces

    def chart(self, triangle):
        """Which chart triangles (k,) of receivers are of."""
        return np.take(self._charts, triangle)

    def receiver(self, triangle):
        """Which receiver triangles (k,) of receivers are of."""
        return np.take(self.image, self.chart(triangle))

    def texel(self, landed):
        """The texels (k,), numbered through all images, that hold what is Landed on fronts."""
        i, j = (np.minimum(v, self.side - 1).astype(np.int64) for v in (landed.x, landed.y))
        return (np.take(self.image, landed.chart) * self.side + j) * self.side + i

    def of(self, rays, end):
        """The Landed of those Rays that end (k,) on triangles of receivers."""
        part = chosen((end >= 0) & (end < self._surfaces.receiving))
        names = "photon", "path", "origin", "direction", "colour", "state", "way"
        photon, path, origin, direction, colour, state, way = (pick(getattr(rays, name), part) for name in names)
        triangle = pick(end, part).astype(np.int64)
        height, x, y = self._maps.take(triangle, 1, mode="clip").reshape(3, 4, -1)
        fall = dot(height, direction)
        distance = dot(height, origin)
        distance += height[3]
        with np.errstate(divide="ignore", invalid="ignore"):  # a surface exactly along the ray
            distance /= -fall
        np.maximum(distance, 0, out=distance)
        distance[~np.isfinite(distance)] = 0.0
        point = distance * direction
        point += origin
        x, y = (self._held(dot(v, point), v[3]) for v in (x, y))
        colour = self._surfaces.dimmed(colour, self._surfaces.crossings.medium.take(state), distance)
        chart = self._charts.take(triangle)
        chart[fall >= 0] = BACK
        return Landed(indices(part, len(end)), photon, path, chart, x, y, colour, way + distance)

    def _held(self, texel, offset):
        """Coordinates (k,) from an offset on, held within the maps."""
        texel += offset
        np.maximum(texel, 0, out=texel)
        return np.minimum(texel, self.side, out=texel)


def _boxes(receivers, charts, count, side):
    """Least and most x and y (2,2,count) [texel] of charts, by those (T,) of all triangles of receivers."""
    uvs = np.concatenate([np.zeros((0, 3, 2)), *(r.uvs for r in receivers)])
    box = np.stack([np.full((2, count), np.inf), np.full((2, count), -np.inf)])
    for axis in range(2):
        np.minimum.at(box[0, axis], charts, uvs[..., axis].min(1))
        np.maximum.at(box[1, axis], charts, uvs[..., axis].max(1))
    return np.clip(box, 0, 1) * side
