"""Sub-points of texels: stratified over what the receiver covers of each, with the area that each stands for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..maps.uv_raster import barycentrics, cross2, touching


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
        self._own, self._corners = texels, np.clip(receiver.uvs, 0, 1) * side
        self._vertices = receiver.positions[receiver.triangles]
        e1, e2 = (self._vertices[:, k] - self._vertices[:, 0] for k in (1, 2))
        normal = np.cross(e1, e2)
        length = np.linalg.norm(normal, axis=1)
        flat = np.abs(cross2(self._corners[:, 1] - self._corners[:, 0], self._corners[:, 2] - self._corners[:, 0]))
        self.normals = normal / np.maximum(length, np.finfo(float).tiny)[:, None]
        self.density = np.where(flat > 0, length / np.where(flat > 0, flat, 1), 0)  # m^2 a texel
        triangle, texel = touching(self._corners, side)
        inside = np.flatnonzero((texels.home[texel] >= 0) & (self.density[triangle] > 0))
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
        uv = ((square + jitter) / m)[:, rank].reshape(2, -1)
        row, column = np.divmod(np.repeat(flat, m * m), self._own.resolution)
        own = np.repeat(triangle, m * m)
        uv = np.stack([column, row], 1) + uv.T
        bary, distance = barycentrics(uv, self._corners[own])
        at = np.flatnonzero(distance == 0)
        own, bary = own[at], bary[at]
        points = (bary[:, :, None] * self._vertices[own]).sum(1)
        texel = self._own.home[np.repeat(flat, m * m)[at]]
        return texel, points, self.normals[own], self.density[own] / (m * m)
