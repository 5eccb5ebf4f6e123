"""The splines on a water's sheets: which vertices lie on them, and positions and normals of points between those."""

from __future__ import annotations

import numpy as np

from .fit import fit
from .sheets import components, find_sheets, turned, turned_back

_CREASE = 0.02  # of the distance of vertices, and
_OUTLIER = 8.0  # deviations: a vertex farther off the spline than both is not on the surface that it describes


class Splines:
    """Height fields fitted to the sheets of a Water with smooth shading.

    smoothing: the Smoothing of the sequence, settled on the sheet whose slopes vary most. sheets: those with vertices
    left on them; cut (T,): whether a triangle hangs together with a vertex on any.
    """

    def __init__(self, water, smoothing):
        self._positions, self._normals = water.positions.T, water.normals.T
        sheets = find_sheets(water.positions, water.triangles)
        self._smoothing = self._settle(smoothing, sheets, water.triangles)
        fields = [self._fit(sheet, water.triangles) for sheet in sheets]
        known = [(sheet, field) for sheet, field in zip(sheets, fields, strict=True) if sheet.on.any()]
        self.sheets, self._fields = [sheet for sheet, _ in known], [field for _, field in known]
        # The side of the normals is that of the mesh's own.
        self._sides = [-1.0 if self._normals[s.axis, s.on].sum() < 0 else 1.0 for s in self.sheets]
        body = components(water.triangles, len(water.positions))
        alive = np.zeros(len(water.positions), bool)
        for sheet in self.sheets:
            alive[body[sheet.on]] = True
        self.cut = alive[body[water.triangles[:, 0]]]

    def _settle(self, smoothing, sheets, triangles):
        """The lambda for these sheets."""
        slopes = [_slopes(turned(self._normals[:, s.support], s.axis)) for s in sheets]
        if not sheets:
            return None
        k = int(np.argmax([(s.var(1) * s.shape[1]).sum() for s in slopes]))
        points = turned(self._positions[:, sheets[k].support], sheets[k].axis)
        return smoothing.settle(points.T, slopes[k], self._distance(sheets[k], triangles))

    def _distance(self, sheet, triangles):
        """Typical distance [m] of neighbours across the heights: as on a square grid of as many vertices."""
        x, y = turned(self._positions, sheet.axis)[:2, triangles[sheet.faces].T]
        area = np.abs((x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0])).sum() / 2
        return float(np.sqrt(area / len(sheet.support)))

    def _fit(self, sheet, triangles):
        """The HeightField of a sheet; vertices that do not lie on it are taken from sheet.on, with two rings."""
        points = turned(self._positions[:, sheet.support], sheet.axis)
        distance = self._distance(sheet, triangles)
        field = fit(points.T, distance, self._smoothing)
        off = np.abs(field.at(*points[:2])[0] - points[2])
        off_it = off > max(_CREASE * distance, _OUTLIER * 1.4826 * np.median(off))
        if off_it.any():
            wrong = np.zeros(len(sheet.on), bool)
            wrong[sheet.support[off_it]] = True
            for _ in range(2):
                wrong[triangles[wrong[triangles].any(1)]] = True
            sheet.on[wrong] = False
        return field

    def between(self, ends, shares):
        """Positions and normals (3, n, m), not unit off the sheets, at the convex combinations shares (c, m) of the
        vertices ends (c, n): on a spline where all of them lie on its sheet, straight between them elsewhere."""
        position, normal = (
            np.einsum("icn,cm->inm", np.take(v, ends, axis=1), shares) for v in (self._positions, self._normals)
        )
        left = np.ones(ends.shape[1], bool)
        for sheet, field, side in zip(self.sheets, self._fields, self._sides, strict=True):
            here = left & sheet.on[ends].all(0)
            left &= ~here
            take = slice(None) if here.all() else np.flatnonzero(here)
            x, y, _ = turned(position[:, take], sheet.axis)
            z, slope_x, slope_y = field.at(x.ravel(), y.ravel()).reshape(3, *x.shape)
            position[:, take] = turned_back(np.stack([x, y, z]), sheet.axis)
            upright = side / np.sqrt(1 + slope_x**2 + slope_y**2)
            normal[:, take] = turned_back(np.stack([-slope_x * upright, -slope_y * upright, upright]), sheet.axis)
        return position, normal

    def deviation(self, edges):
        """Slopes over the plan at the middles of edges (2,n) less the mean of their ends', as a length (n,), at most 1,
        and the edges' lengths (n,) in plan; 0 off the sheets over the plan."""
        (_, middle), (_, ends) = (self.between(edges, shares) for shares in (np.full((2, 1), 0.5), np.eye(2)))
        off = np.hypot(*(_slopes(middle)[..., 0] - _slopes(ends).mean(-1)))
        on = np.zeros(edges.shape[1], bool)
        for sheet in self.sheets:
            on |= sheet.on[edges].all(0) & (sheet.axis == 2)
        run = self._positions[:2, edges[1]] - self._positions[:2, edges[0]]
        return np.where(on, np.minimum(off, 1.0), 0.0), np.hypot(*run)

    def count(self, triangles):
        """How many of triangles (T,3) follow splines over the plan, and over upright planes."""
        left, found = np.ones(len(triangles), bool), [0, 0]
        for sheet in self.sheets:
            here = left & sheet.on[triangles].all(1)
            left &= ~here
            found[sheet.axis != 2] += np.count_nonzero(here)
        return found


def _slopes(normals):
    """Slopes (2, ...) of a surface with normals (3, ...)."""
    return -normals[:2] / np.where(normals[2] == 0, np.inf, normals[2])
