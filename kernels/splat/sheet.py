"""A sheet of images on which beams leave their flux: triangles by exact coverage, points by the texel they lie in."""

from __future__ import annotations

import numpy as np

from ..maps.coverage import edge_coverage
from ..maps.uv_raster import cross2

_ROUNDING = 1e-13  # of all flux
_THIN = 1e-9  # texels^2: images without area land point by point


class Sheet:
    """`images` images of resolution^2 texels, one above the other; image (charts,) says which one each chart is in."""

    def __init__(self, image, images, resolution):
        self.image, self.images, self.resolution = image, images, resolution
        self._starts, self._ends, self._weights = [], [], []
        self._flux = np.zeros(images * resolution**2)

    def add_triangles(self, chart, x, y, flux):
        """Spread flux (n,) evenly over triangles x, y (n,3) [texel] of charts chart (n,)."""
        x, y = (np.clip(v, 0, self.resolution) for v in (x, y))
        area = cross2(*(np.stack([x[:, k] - x[:, 0], y[:, k] - y[:, 0]], 1) for k in (1, 2))) / 2
        i, j = np.floor(x), np.floor(y)
        inside = (i == i[:, :1]).all(1) & (j == j[:, :1]).all(1)
        direct = inside | (np.abs(area) < _THIN)
        spread = np.flatnonzero(~direct)
        self.add_points(
            np.repeat(chart[direct], 3), x[direct].ravel(), y[direct].ravel(), np.repeat(flux[direct] / 3, 3)
        )
        y = y[spread] + (self.image[chart[spread]] * self.resolution)[:, None]
        after = [1, 2, 0]
        self._starts.append(np.stack([x[spread].ravel(), y.ravel()]))
        self._ends.append(np.stack([x[spread][:, after].ravel(), y[:, after].ravel()]))
        self._weights.append(np.repeat(flux[spread] / area[spread], 3))

    def add_points(self, chart, x, y, flux):
        """Leave flux (n,) in the texels that hold the points x, y (n,)."""
        top = self.resolution - 1
        i, j = np.clip(x, 0, top).astype(np.int64), np.clip(y, 0, top).astype(np.int64)
        cell = (self.image[chart] * self.resolution + j) * self.resolution + i
        self._flux += np.bincount(cell, flux, minlength=len(self._flux))

    def flux(self):
        """Flux (images * resolution^2,) of all texels."""
        if not self._starts:
            return self._flux
        shape = (self.images * self.resolution, self.resolution)
        edges = (np.concatenate(v, axis=-1) for v in (self._starts, self._ends, self._weights))
        starts, ends, weights = edges
        flux = self._flux + edge_coverage(starts, ends, weights[None], shape).ravel()
        flux[np.abs(flux) < _ROUNDING * flux.sum()] = 0  # what sums along a row leave in texels that nothing covers
        return flux
