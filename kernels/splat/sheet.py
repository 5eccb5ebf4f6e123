"""A sheet of images on which beams leave their flux: triangles by exact coverage, points by the texel they lie in."""

from __future__ import annotations

import numpy as np

from ..maps.coverage import edge_coverage

_ROUNDING = 1e-13  # of all flux
_THIN = 1e-9  # texels^2: images without area land point by point
_NEXT = [1, 2, 0]
_MANY = 0.25  # of the texels: fewer points are added one by one
_BLOCK = 1 << 16  # cells at once


class Sheet:
    """`images` images of resolution^2 texels, one above the other, in `channels`, every texel in grain^2 cells; image
    (charts,) says which one each chart is in. `landed` (C,) is the flux of all that was left,
    that beyond the image's rim included."""

    def __init__(self, image, images, resolution, channels=1, grain=1):
        self.image, self.images, self.channels = image, images, channels
        self.resolution, self.grain, self.side = resolution, grain, grain * resolution  # side in cells
        self.landed = np.zeros(channels)
        self._starts, self._ends, self._weights = [], [], []
        self._flux = np.zeros((channels, images * self.side**2))

    def add_triangles(self, chart, x, y, flux):
        """Spread flux (C,n) evenly over triangles x, y (3,n) [texel] of charts chart (n,)."""
        x, y = self._cells(x), self._cells(y)
        spread, density = self._densities(chart, x, y, flux)
        x, y = x[:, spread], y[:, spread] + np.take(self.image, chart[spread]) * self.side
        self._starts.append(np.stack([x.ravel(), y.ravel()]))
        self._ends.append(np.stack([x[_NEXT].ravel(), y[_NEXT].ravel()]))
        self._weights.append(np.tile(density, 3))

    def add_parallelograms(self, chart, x, y, flux):
        """Spread flux (C,n) evenly over parallelograms with corners x, y (4,n) [texel], one after the other."""
        x, y = self._cells(x), self._cells(y)
        area = (x[1] - x[0]) * (y[3] - y[0]) - (x[3] - x[0]) * (y[1] - y[0])
        spread, at = np.flatnonzero(np.abs(area) >= _THIN), np.flatnonzero(np.abs(area) < _THIN)
        for k in range(4):
            self._leave(chart[at], x[k, at], y[k, at], flux[:, at] / 4)
        self.landed += flux[:, spread].sum(1)
        x, y = x[:, spread], y[:, spread] + np.take(self.image, chart[spread]) * self.side
        self._starts.append(np.stack([x.ravel(), y.ravel()]))
        self._ends.append(np.stack([np.roll(x, -1, 0).ravel(), np.roll(y, -1, 0).ravel()]))
        self._weights.append(np.tile(flux[:, spread] / area[spread], 4))

    def add_mesh(self, mesh, index, x, y, flux):
        """As `add_triangles`, triangles index (n,) of MeshNodes: the edges that two of them share carry the difference
        of their densities."""
        edges = mesh.edges
        chart = np.take(mesh.chart, np.take(edges.corner[0], index))
        spread, own = self._densities(chart, self._cells(x), self._cells(y), flux)
        density = np.zeros((self.channels, edges.corner.shape[1]))
        density[:, index[spread]] = own
        weights = edges.differences(density)
        used = np.flatnonzero(weights.any(0))
        tail, head = edges.tail[used], edges.head[used]
        chart, x, y = (values[: mesh.vertices] for values in (mesh.chart, mesh.x, mesh.y))
        above = np.take(self.image, np.maximum(chart, 0)) * self.side
        place = np.stack([self._cells(x), self._cells(y) + above])
        self._starts.append(np.take(place, tail, axis=1))
        self._ends.append(np.take(place, head, axis=1))
        self._weights.append(np.take(weights, used, axis=1))

    def _cells(self, v):
        """Texel coordinates v as those of cells."""
        return v if self.grain == 1 else v * self.grain

    def _densities(self, chart, x, y, flux):
        """Indices (s,) of the triangles x, y (3,n) [cell] to spread, and their densities (C,s); leaves the others."""
        area = ((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2
        i, j = np.floor(x), np.floor(y)
        inside = (i[0] == i[1]) & (i[0] == i[2]) & (j[0] == j[1]) & (j[0] == j[2])
        direct = inside | (np.abs(area) < _THIN)
        spread = np.flatnonzero(~direct)
        self.landed += np.take(flux, spread, axis=1).sum(1)
        at = np.flatnonzero(direct)
        for k in range(3):
            self._leave(chart[at], x[k, at], y[k, at], flux[:, at] / 3)
        return spread, np.take(flux, spread, axis=1) / area[spread]

    def add_points(self, chart, x, y, flux):
        """Leave flux (C,n) in the texels that hold the points x, y (n,)."""
        self._leave(chart, self._cells(x), self._cells(y), flux)

    def _leave(self, chart, x, y, flux):
        """As `add_points`, at x, y (n,) [cell]."""
        side = self.side
        self.landed += flux.sum(1)
        inside = np.flatnonzero((x >= 0) & (x <= side) & (y >= 0) & (y <= side))
        i, j = (np.minimum(v[inside], side - 1).astype(np.int64) for v in (x, y))
        cell = (np.take(self.image, chart[inside]) * side + j) * side + i
        for own, more in zip(self._flux, flux, strict=True):
            if len(cell) > _MANY * len(own):
                own += np.bincount(cell, more[inside], len(own))
            else:
                np.add.at(own, cell, more[inside])

    def flux(self):
        """Flux (C, images * (grain resolution)^2) of all cells."""
        if not self._starts:
            return self._flux
        shape = (self.images * self.side, self.side)
        edges = (np.concatenate(v, axis=-1) for v in (self._starts, self._ends, self._weights))
        self._flux.reshape(self.channels, *shape)[:] += edge_coverage(*edges, shape)
        self._starts, self._ends, self._weights = [], [], []
        for own in self._flux:
            floor = _ROUNDING * own.sum()
            for k in range(0, len(own), _BLOCK):
                part = own[k : k + _BLOCK]
                part[np.abs(part) < floor] = 0  # what sums along a row leave in texels that nothing covers
        return self._flux
