"""The smooth surface through a water's vertices: which of them lie on which sheet's spline, where tangents join those,
and positions and normals between the vertices."""

from __future__ import annotations

import numpy as np

from .compact import compact
from .fit import fit, fit_tolerance
from .footprints import Triangles
from .hermite import between_corners
from .scaffold import Scaffold
from .sheets import find_sheets, turned, turned_back
from .smoothing import ON_THE_SURFACE

_CREASE = 0.02  # of the distance of vertices, and
_OUTLIER = 8.0  # deviations: a vertex farther off the spline than both is not on the surface that it describes


class Splines:
    """Height fields fitted to the sheets of a Water with smooth shading, and cubics between vertices that share none.

    smoothing: the Smoothing of the sequence, and afterwards that of this Water; tolerance: the relative mean squared
    error of the light that is good enough, 0 for the best fit there is; scaffold: the Scaffold of the sequence. sheets:
    those with vertices left on them; cut (T,): whether a triangle hangs together with a vertex on any. positions,
    normals (3,V): of the vertices on this surface.
    """

    def __init__(self, water, smoothing, tolerance=0.0, scaffold=None):
        self._scaffold = scaffold or Scaffold()
        body = self._scaffold.body(water.triangles, len(water.positions))
        self._tolerance = fit_tolerance(tolerance)
        self.positions, self.normals = water.positions.T, water.normals.T
        sheets = find_sheets(water.positions, water.triangles, body)
        self.smoothing = settled(smoothing, water, sheets)
        fields = [self._fit(sheet, water.triangles) for sheet in sheets]
        known = [(sheet, field) for sheet, field in zip(sheets, fields, strict=True) if sheet.on.any()]
        self.sheets, self._fields = [sheet for sheet, _ in known], [field for _, field in known]
        # The side of the normals is that of the mesh's own.
        self._sides = [-1.0 if self.normals[s.axis, s.on].sum() < 0 else 1.0 for s in self.sheets]
        alive = np.zeros(len(water.positions), bool)
        for sheet in self.sheets:
            alive[body[sheet.on]] = True
        self.cut = alive[body[water.triangles[:, 0]]]
        self._known = np.zeros(len(alive), bool)
        corners = np.arange(len(alive))[None], np.ones((1, 1))
        self.positions, self.normals = (v[..., 0] for v in self.between(*corners))
        self._join(water.triangles)

    def _join(self, triangles):
        """Find the tangents at all corners of triangles that lie on no one sheet, where the mesh resolves them."""
        apart = self.cut & ~self._on_one(triangles)
        if not apart.any():
            return
        near, corner = (np.zeros(len(self._known), bool) for _ in range(2))
        near[triangles[apart]] = corner[triangles[apart]] = True
        for _ in range(2):
            round_it = self.cut & near[triangles].any(1)
            near[triangles[round_it]] = True
        on = np.any([sheet.on for sheet in self.sheets], axis=0)
        found = compact(self.positions, self.normals, triangles[round_it], on)
        use = np.flatnonzero(found.sound & corner[found.vertices])
        at = found.vertices[use]
        self._known[at] = True
        self.normals[:, at] = found.normals[:, use]
        self._turns = np.zeros((3, 3, len(self._known)))
        self._turns[:, :, at] = found.turns[:, :, use]

    def _on_one(self, triangles):
        """Whether all corners of triangles (n,3) lie on one sheet."""
        return np.any([sheet.on[triangles].all(1) for sheet in self.sheets], axis=0)

    def _fit(self, sheet, triangles):
        """The HeightField of a sheet; vertices that do not lie on it are taken from sheet.on, with two rings. Vertices
        that are off the water get cells as wide as their spacing: finer ones follow the pattern of an iso-surface."""
        points = turned(self.positions[:, sheet.support], sheet.axis)
        smoothing = self.smoothing.value
        distance = sheet.distance
        if smoothing > ON_THE_SURFACE:
            distance = _spacing(self.positions, sheet, triangles)
        field = fit(points.T, distance, smoothing, self._tolerance, self._scaffold.samples)
        off = np.abs(field.at(*points[:2])[0] - points[2])
        off_it = off > max(_CREASE * sheet.distance, _OUTLIER * 1.4826 * np.median(off))
        if off_it.any():
            wrong = np.zeros(len(sheet.on), bool)
            wrong[sheet.support[off_it]] = True
            for _ in range(2):
                wrong[triangles[wrong[triangles].any(1)]] = True
            sheet.on[wrong] = False
        return field

    def between(self, ends, shares):
        """Positions and normals (3, n, m), not unit off the sheets, at the convex combinations shares (c, m) of the
        vertices ends (c, n): on a spline where all of them lie on its sheet, on a cubic where all their tangents are
        known, straight between them elsewhere."""
        position, normal = (
            np.einsum("icn,cm->inm", np.take(v, ends, axis=1), shares) for v in (self.positions, self.normals)
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
        joined = np.flatnonzero(left & self._known[ends].all(0))
        if len(joined) and len(ends) > 1:
            at = ends[:, joined]
            cubic = between_corners(self.positions[:, at], self.normals[:, at], self._turns[:, :, at], shares)
            position[:, joined], normal[:, joined] = cubic[:3], cubic[3:]
        return position, normal

    def deviation(self, edges):
        """Slopes over the plan at the middles of edges (2,n) less the mean of their ends', as a length (n,), at most 1,
        and the edges' lengths (n,) in plan; the same of the normals on cubics, and 0 elsewhere."""
        middle, ends = self.between(edges, np.full((2, 1), 0.5))[1][..., 0], self.normals[:, edges]
        off = np.minimum(np.hypot(*(_slopes(middle) - _slopes(ends).mean(1))), 1.0)
        on = np.zeros(edges.shape[1], bool)
        for sheet in self.sheets:
            on |= sheet.on[edges].all(0) & (sheet.axis == 2)
        cubic = ~on & self._known[edges].all(0)
        off[cubic] = np.sqrt(((middle - ends.mean(1))[:, cubic] ** 2).sum(0))
        run = self.positions[:2, edges[1]] - self.positions[:2, edges[0]]
        return np.where(on | cubic, off, 0.0), np.hypot(*run)

    def some(self, water, count):
        """About `count` Triangles of a Water that follow splines over the plan, evenly through it; None where less than
        half of it does."""
        ids = np.arange(0, len(water.triangles), max(1, len(water.triangles) // count))
        corner = water.triangles[ids].T
        here = np.any([s.on[corner].all(0) for s in self.sheets if s.axis == 2] or [np.zeros(len(ids), bool)], axis=0)
        if here.mean() < 0.5:
            return None
        corner = corner[:, here]
        edges = np.stack([corner, np.roll(corner, -1, axis=0)]).reshape(2, -1)
        middles = self.between(edges, np.full((2, 1), 0.5))[1][..., 0].reshape(3, *corner.shape)
        normals = np.take(self.normals, corner, axis=1), middles, np.take(water.normals.T, corner, axis=1)
        return Triangles(np.take(self.positions[:2], corner, axis=1), *map(_slopes, normals))

    def count(self, triangles):
        """How many of triangles (T,3) follow splines over the plan, splines over upright planes, and cubics."""
        left, found = np.ones(len(triangles), bool), [0, 0, 0]
        for sheet in self.sheets:
            here = left & sheet.on[triangles].all(1)
            left &= ~here
            found[sheet.axis != 2] += np.count_nonzero(here)
        found[2] = np.count_nonzero(left & self._known[triangles].all(1))
        return found


def settled(smoothing, water, sheets=None):
    """A Smoothing settled on the sheet of a Water whose slopes vary most; as it is, where the Water has no sheet."""
    sheets = find_sheets(water.positions, water.triangles) if sheets is None else sheets
    if not sheets:
        return smoothing
    positions, normals = water.positions.T, water.normals.T
    slopes = [_slopes(turned(normals[:, s.support], s.axis)) for s in sheets]
    k = int(np.argmax([(s.var(1) * s.shape[1]).sum() for s in slopes]))
    points = turned(positions[:, sheets[k].support], sheets[k].axis)
    return smoothing.settled(points.T, slopes[k], _spacing(positions, sheets[k], water.triangles))


def _spacing(positions, sheet, triangles):
    """How far apart [m] vertices (3,V) are at the farthest: the longest edges over sqrt 2, in the mean by area."""
    x, y = turned(positions, sheet.axis)[:2, triangles[sheet.faces].T]
    longest = np.sqrt(np.max([(x[k] - x[k - 1]) ** 2 + (y[k] - y[k - 1]) ** 2 for k in range(3)], axis=0))
    area = np.abs((x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]))
    return float((longest * area).sum() / area.sum() / np.sqrt(2))


def _slopes(normals):
    """Slopes (2, ...) of a surface with normals (3, ...)."""
    return -normals[:2] / np.where(normals[2] == 0, np.inf, normals[2])
