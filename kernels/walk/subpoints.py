"""Sub-points of texels: stratified over what the receiver covers of each, with the area that each stands for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..maps.uv_raster import touching


@dataclass
class SubPoints:
    """Points (n,3) of a receiver with its normals (n,3) there, and the texel (n,) in 0..K-1 that owns each; area (n,)
    [m^2] that each stands for in the mean over draws, and scale (n,), what makes it that of this draw."""

    texel: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    area: np.ndarray
    scale: np.ndarray

    @classmethod
    def concatenated(cls, parts):
        return cls(*(np.concatenate(a) for a in zip(*(vars(part).values() for part in parts), strict=True)))


class SubTexels:
    """Where the sub-points of a Receiver's Texels may lie."""

    def __init__(self, receiver, texels):
        side = texels.resolution
        self._own, corners = texels, np.clip(receiver.uvs, 0, 1) * side
        v = receiver.positions[receiver.triangles]
        self._origin, self._edges = v[:, 0].T, (v[:, 1:] - v[:, :1]).transpose(1, 2, 0)
        normal = np.cross(*self._edges, axis=0)
        length = np.sqrt((normal**2).sum(0))
        (x1, y1), (x2, y2) = (corners[:, 1:] - corners[:, :1]).transpose(1, 2, 0)
        flat = x1 * y2 - x2 * y1
        inverse = 1 / np.where(flat == 0, np.inf, flat)
        self._low = corners[:, 0].T
        self._slopes = (y2 * inverse, -x2 * inverse), (-y1 * inverse, x1 * inverse)  # of the weights, in UV
        self._normals = (normal / np.maximum(length, np.finfo(float).tiny)).T
        self._density = length * np.abs(inverse)  # m^2 a texel
        triangle, texel = touching(corners, side)
        inside = np.flatnonzero((texels.home[texel] >= 0) & (self._density[triangle] > 0))
        order = inside[np.argsort(texel[inside], kind="stable")]
        self._triangle, self._flat, self._home = triangle[order], texel[order], texels.home[texel[order]]

    def draw(self, strata, rng):
        """SubPoints of texels with strata (K,) > 0: one at random in each of strata^2 squares of every texel, where the
        receiver is; one at the texel's own position where it meets none."""
        own, count = self._own, len(strata)
        parts = [self._level(m, strata, rng) for m in np.unique(strata[strata > 0])]
        texel, points, normals, area = (np.concatenate(c) for c in zip(*parts, strict=True))
        total = np.bincount(texel, area, minlength=count)
        bare = np.flatnonzero((strata > 0) & (total == 0))
        total[bare] = own.area[bare]
        texel, area = np.concatenate([texel, bare]), np.concatenate([area, own.area[bare]])
        points, normals = np.concatenate([points, own.positions[bare]]), np.concatenate([normals, own.normals[bare]])
        return SubPoints(texel, points, normals, area, own.area[texel] / total[texel])

    def _level(self, m, strata, rng):
        """Texel, point, normal and area of the sub-points of the texels that have m^2 squares."""
        pair = np.flatnonzero(strata[self._home] == m)
        flat, triangle = self._flat[pair], self._triangle[pair]
        first = np.concatenate([[True], flat[1:] != flat[:-1]])[: len(flat)]
        rank = np.cumsum(first) - 1  # pairs of one texel share its points
        jitter = rng.random((2, np.count_nonzero(first), m * m))
        square = np.stack(np.divmod(np.arange(m * m), m))[::-1, None]
        row, column = np.divmod(flat, self._own.resolution)
        x, y = ((square + jitter) / m)[:, rank]
        x += (column - self._low[0].take(triangle))[:, None]
        y += (row - self._low[1].take(triangle))[:, None]
        a, b = (cx.take(triangle)[:, None] * x + cy.take(triangle)[:, None] * y for cx, cy in self._slopes)
        at = np.flatnonzero((a >= 0) & (b >= 0) & (a + b <= 1))
        pair, a, b = at // (m * m), a.ravel()[at], b.ravel()[at]
        own = triangle[pair]
        points = np.empty((len(own), 3))
        for axis, (o, e1, e2) in enumerate(zip(self._origin, *self._edges, strict=True)):
            points[:, axis] = o.take(own) + a * e1.take(own) + b * e2.take(own)
        return self._own.home[flat[pair]], points, self._normals[own], self._density[own] / (m * m)
