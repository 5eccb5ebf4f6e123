"""From points on receivers to texels: the flux that each takes, and how wide its splat is."""

from __future__ import annotations

import numpy as np

from ..maps.texels import gather_all
from ..optics import dot
from ..rays import MISS
from ..splat.lander import texel_maps

_SPREAD = 0.6  # deviation of a splat, of the distance to the next one: the gaps between them are 2e-3 of the light
_SHARP = 0.5  # texels: deviation of a Gaussian that lies on three by three texels
_GRAZING = 1e-3  # cosine of incidence, for the size of splats
# Cosine between a ray and the way to where it is said to land, at least, else look-ups found nothing; mirrored: True.
_ASTRAY = {False: 0.99, True: 0.9998}
_TINY = np.finfo(float).tiny
_TABLE = np.linspace(-6, 6, 4801)
_BELOW = np.cumsum(np.exp(-0.5 * (_TABLE - 0.5 * (_TABLE[1] - _TABLE[0])) ** 2))
_BELOW = (_BELOW - _BELOW[0]) / (_BELOW[-1] - _BELOW[0])  # share of a Gaussian below so many deviations


class Landing:
    """What lands on the Texels of `receivers`, which come first in Solids, per unit of the light's power."""

    def __init__(self, receivers, texels, solids):
        self._texels, self._solids = texels, solids
        self._side = texels[0].resolution
        maps = [texel_maps(r, self._side)[:, 1:] for r in receivers]
        self._maps = np.concatenate(maps).transpose(1, 2, 0)
        self._image = np.repeat(np.arange(len(receivers)), [len(r.triangles) for r in receivers])
        part, count = [], 0
        for own in texels:
            number = np.append(own.chart[own.triangle] + count, MISS)
            part.append(number[own.home])
            count += own.chart.max(initial=-1) + 1
        self._part = np.concatenate(part)
        self.parts = count
        self._area = np.array([t.area.sum() / max(len(t.area), 1) for t in texels])

    def land(self, bent, point, triangle, length):
        """Flux (C, images * side^2) of Bent light that lands at point (3,n) on triangles (n,) after `length` (n,) [m],
        {cause: (C,)} of what is lost, and the footprint area (parts,) [texel^2] of a splat on each chart."""
        facing = -dot(bent.r, self._normals(triangle))
        ahead = dot(point - bent.v, bent.r) > _ASTRAY[bent.mirrored] * length
        seen = (triangle != MISS) & ahead
        on = seen & (triangle < self._solids.receiving)
        good = np.flatnonzero(on & (facing > 0))
        flux = bent.flux
        if bent.sigma_a.any():
            flux = flux * np.exp(-bent.sigma_a[:, None] * np.where(seen, length, 0.0))
        total = np.array([f[~on].sum() for f in bent.flux])
        lost = {
            "missed": np.array([f[~seen].sum() for f in bent.flux]),
            "back": np.array([f[on & (facing <= 0)].sum() for f in bent.flux]),
            "absorbed": (bent.flux - flux)[:, good].sum(1) if flux is not bent.flux else np.zeros(len(flux)),
        }
        lost["occluded"] = total - lost["missed"]
        area = bent.area * (1 + length / bent.away) ** 2 / np.maximum(facing, _GRAZING)
        footprints = self._footprints(area[good], triangle[good])
        sharp = np.minimum(_SPREAD * np.sqrt(footprints), _SHARP)[self._solids.part[triangle[good]]]
        cells, shares = self._taps(point[:, good], triangle[good], sharp)
        count = len(self._texels) * self._side**2
        images = np.stack([np.bincount(cells.ravel(), (shares * f[good]).ravel(), count) for f in flux])
        return images, lost, footprints

    def _normals(self, triangle):
        """Unit normals (3,n) of triangles (n,), by their winding."""
        v = [self._solids.positions[self._solids.triangles[triangle, k]] for k in range(3)]
        across = np.cross(v[1] - v[0], v[2] - v[0]).T
        return across / np.maximum(np.sqrt(dot(across, across)), _TINY)

    def _taps(self, point, triangle, sharp):
        """Cells (9,n) of the images and shares (9,n) that each takes of the flux of splats at points, Gaussians of
        deviations sharp (n,) [texel]: those of its own chart."""
        side = self._side
        own = np.take(self._maps, triangle, axis=2)
        x, y = (own[k, 0] * point[0] + own[k, 1] * point[1] + own[k, 2] * point[2] + own[k, 3] for k in range(2))
        x, y = np.clip(x, 0, side * (1 - 1e-12)), np.clip(y, 0, side * (1 - 1e-12))
        base = self._image[triangle] * side**2
        j, i = x.astype(np.int64), y.astype(np.int64)
        across, along = _three(x - j, sharp), _three(y - i, sharp)
        cells, shares = np.empty((9, len(x)), np.int64), np.empty((9, len(x)))
        for k in range(9):
            row, column = i + k // 3 - 1, j + k % 3 - 1
            inside = (column >= 0) & (column < side) & (row >= 0) & (row < side)
            cells[k] = base + np.where(inside, row * side + column, 0)
            inside &= self._part[cells[k]] == self._solids.part[triangle]
            shares[k] = np.where(inside, along[k // 3] * across[k % 3], 0.0)
        total = shares.sum(0)
        lone = total <= 0
        cells[4, lone] = (base + i * side + j)[lone]
        shares[4, lone] = total[lone] = 1.0
        return cells, shares / total

    def _footprints(self, area, triangle):
        """Area (parts,) [texel^2] of splats on each chart, by their mean density."""
        density, part = self._area[self._image[triangle]] / np.maximum(area, _TINY), self._solids.part[triangle]
        count = np.bincount(part, minlength=self.parts)
        return count / np.maximum(np.bincount(part, density, self.parts), _TINY)

    def rest(self, footprints):
        """Deviations [texel] of the Gaussians that are still to be given to splats of these areas, per receiver those
        of its charts."""
        wide = _SPREAD**2 * footprints
        cuts = np.cumsum([t.chart.max(initial=-1) + 1 for t in self._texels])[:-1]
        return np.split(np.sqrt(np.maximum(wide - _SHARP**2, 0.0)), cuts)

    def owned(self, images):
        """What the texels own (C,K) of flux (C, images * side^2), and what lies off the charts (C,)."""
        return gather_all(self._texels, images)


def _three(x, deviation):
    """Shares (3,n) of Gaussians at x (n,), 0 to 1 in their own cell, in the cell before it, in it and after it."""
    deviation = np.maximum(deviation, _TINY)
    before = np.interp(-x / deviation, _TABLE, _BELOW)
    after = np.interp((x - 1) / deviation, _TABLE, _BELOW)
    return np.stack([before, 1 - before - after, after])
