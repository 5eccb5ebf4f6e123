"""The splines on a water's sheets: which vertices lie on them, and positions and normals of points between those."""

from __future__ import annotations

import numpy as np

from .fit import fit
from .sheets import components, find_sheets
from .smoothing import choose_smoothing

_CREASE = 0.02  # of the distance of vertices, and
_OUTLIER = 8.0  # deviations: a vertex farther off the spline than both is not on the surface that it describes


class Splines:
    """Height fields fitted to a Water with smooth shading.

    smoothing: lambda of `fit.py`, chosen from the largest sheet where it is None. sheet (V,): the height field that
    each vertex lies on, -1 where it stays as it is; cut (T,): whether a triangle hangs together with any that lies on
    one.
    """

    def __init__(self, water, smoothing=None):
        self._positions, self._normals = water.positions, water.normals
        sheets = find_sheets(water.positions, water.triangles)
        self.sheet, self.smoothing = sheets.number.copy(), smoothing
        of_sheets = [self._points(water.triangles, sheets, k) for k in range(sheets.count)]
        if smoothing is None and of_sheets:
            used, distance = max(of_sheets, key=lambda points: len(points[0]))
            slopes = self._slopes(None, self._normals[used].T)
            self.smoothing = choose_smoothing(self._positions[used], slopes, distance)
        self._fields = [self._fit(water.triangles, k, *points) for k, points in enumerate(of_sheets)]
        body = components(water.triangles, len(self.sheet))
        on = np.zeros(len(self.sheet), bool)
        on[body[self.sheet >= 0]] = True
        self.cut = on[body[water.triangles[:, 0]]]
        # The normals' side of a sheet is that of the mesh's own.
        upward = [self._normals[self.sheet == k, 2].sum() for k in range(sheets.count)]
        self._side = np.where(np.array(upward) < 0, -1.0, 1.0)

    def _points(self, triangles, sheets, k):
        """The vertices (n,) that the surface of sheet k is fitted to, and their typical distance [m]."""
        distance = typical_distance(self._positions, triangles[(sheets.support[triangles] == k).all(1)])
        return np.flatnonzero(sheets.support == k), distance

    def _fit(self, triangles, k, used, distance):
        """The HeightField of sheet k through the vertices `used`; takes from the sheet what does not lie on it."""
        points = self._positions[used]
        field = fit(points, distance, self.smoothing)
        off = np.abs(field.at(points[:, 0], points[:, 1])[0] - points[:, 2])
        off_it = off > max(_CREASE * distance, _OUTLIER * 1.4826 * np.median(off))
        if off_it.any():
            wrong = np.zeros(len(self.sheet), bool)
            wrong[used[off_it]] = True
            for _ in range(2):
                wrong[triangles[wrong[triangles].any(1)]] = True
            self.sheet[wrong & (self.sheet == k)] = -1
        return field

    def between(self, ends, shares):
        """Positions and normals (3, n, m), not unit off the sheets, at the convex combinations shares (c, m) of the
        vertices ends (c, n): on a spline where all of them lie on one sheet, straight between them elsewhere."""
        position, normal = (
            np.einsum("cin,cm->inm", np.take(v, ends, axis=0).transpose(0, 2, 1), shares)
            for v in (self._positions, self._normals)
        )
        sheet = self.sheet[ends]
        common = np.where((sheet == sheet[0]).all(0), sheet[0], -1)
        for k, field in enumerate(self._fields):
            here = common == k
            take = slice(None) if here.all() else np.flatnonzero(here)
            x, y = position[0, take], position[1, take]
            z, slope_x, slope_y = field.at(x.ravel(), y.ravel()).reshape(3, *x.shape)
            position[2, take] = z
            upright = self._side[k] / np.sqrt(1 + slope_x**2 + slope_y**2)
            normal[:, take] = np.stack([-slope_x * upright, -slope_y * upright, upright])
        return position, normal

    def deviation(self, edges):
        """Slopes at the middles of edges (2,n) less the mean of their ends', as a length (n,), and the edges' lengths
        (n,) in plan; 0 off the sheets."""
        middle, ends = (self._slopes(*self.between(edges, shares)) for shares in (_MIDDLE, np.eye(2)))
        off = middle[:, :, 0] - ends.mean(2)
        run = self._positions[edges[1], :2] - self._positions[edges[0], :2]
        return np.where((self.sheet[edges] >= 0).all(0), np.hypot(*off), 0.0), np.hypot(*run.T)

    @staticmethod
    def _slopes(_, normal):
        return -normal[:2] / np.where(normal[2] == 0, np.inf, normal[2])


_MIDDLE = np.full((2, 1), 0.5)


def typical_distance(positions, triangles):
    """Distance [m] in plan of neighbours in triangles (T,3): longest edges over sqrt 2, in the mean by area."""
    x, y = (np.take(positions[:, k], triangles.T) for k in (0, 1))
    longest = np.sqrt(np.max([(x[k] - x[k - 1]) ** 2 + (y[k] - y[k - 1]) ** 2 for k in range(3)], axis=0))
    area = np.abs((x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]))
    return float((longest * area).sum() / area.sum() / np.sqrt(2))
