"""The light's view: a plane on which all that it shines on is drawn, parallel for a sun, in perspective for a lamp."""

from __future__ import annotations

import numpy as np

from ..optics import sun_frame
from ..scene import Spot, Sun
from ..sources import falloff

_WIDEST = 8.0  # tangent of the angle off the axis, at most
_BEYOND = 1.01  # of the scene: how far away parallel rays start
_TINY = np.finfo(float).tiny


class View:
    """The view of a light: (u, v) of world points are [m] across the rays of a Sun, tangents off the axis of a lamp.

    axis (3,): unit direction in which a lamp looks; points (3,n): what the scene is made of.
    """

    def __init__(self, light, axis, points):
        self.light, self.parallel = light, isinstance(light, Sun)
        self.frame = sun_frame(light.direction if self.parallel else axis)
        self._eye = np.zeros(3) if self.parallel else np.asarray(light.position, float)
        depth = self.frame[2] @ (points - self._eye[:, None])
        centre = (depth.max() + depth.min()) / 2
        self._near = centre + _BEYOND * (depth.max() - centre)
        self._far = centre + _BEYOND * (depth.min() - centre)

    def project(self, p):
        """(u, v) (2,n) of points p (3,n); not a number for what is behind a lamp."""
        q = self.frame @ (p - self._eye[:, None])
        if self.parallel:
            return q[:2]
        return q[:2] / np.where(q[2] < 0, -q[2], np.nan)

    def rays(self, uv):
        """Origins and unit directions (3,n) of the light's rays at uv (2,n)."""
        direction = self._direction(uv)
        if self.parallel:
            return self.frame[:2].T @ uv + self._near * self.frame[2][:, None], direction
        return np.repeat(self._eye[:, None], uv.shape[1], 1), direction

    def from_behind(self, uv):
        """As `rays`, towards the light from behind all there is."""
        direction = self._direction(uv)
        if self.parallel:
            return self.frame[:2].T @ uv + self._far * self.frame[2][:, None], -direction
        away = -self._far * np.sqrt(1 + (uv * uv).sum(0))
        return self._eye[:, None] + away * direction, -direction

    def _direction(self, uv):
        if self.parallel:
            return np.repeat(-self.frame[2][:, None], uv.shape[1], 1)
        toward = self.frame.T @ np.concatenate([uv, -np.ones((1, uv.shape[1]))])
        return toward / np.sqrt((toward * toward).sum(0))

    def towards(self, p):
        """Unit directions (3,n) from points p (3,n) to the light, and distances (n,) or inf."""
        if self.parallel:
            return np.broadcast_to(self.frame[2][:, None], p.shape), np.inf
        away = self._eye[:, None] - p
        distance = np.sqrt((away * away).sum(0))
        return away / np.maximum(distance, _TINY), distance

    def density(self, uv):
        """What falls (n,) into each unit of the plane: [W] for 1 W/m^2 of a sun, 1 W/sr of a lamp."""
        if self.parallel:
            return np.ones(uv.shape[1])
        solid_angle = (1 + (uv * uv).sum(0)) ** -1.5
        return solid_angle * falloff(self.light, self._direction(uv)) if isinstance(self.light, Spot) else solid_angle

    def bounds(self, p):
        """Least and greatest (u, v) (2,), (2,) of points p (3,n), as far as they are in view; None for none."""
        uv = self.project(p)
        uv = uv[:, np.isfinite(uv).all(0)]
        if not uv.size:
            return None
        low, high = uv.min(1), uv.max(1)
        return (low, high) if self.parallel else (np.maximum(low, -_WIDEST), np.minimum(high, _WIDEST))


class Raster:
    """Square cells on a View's plane from `low` to `high` (2,), `count` along the longer side: shape (rows, columns),
    cell, their width, and centres (2, cells)."""

    def __init__(self, low, high, count):
        size = np.maximum(high - low, _TINY)
        self.cell = float(size.max() / count)
        columns, rows = np.maximum(np.ceil(size / self.cell - 1e-9), 1).astype(int)
        self.low = (low + high) / 2 - np.array([columns, rows]) * self.cell / 2
        self.shape = rows, columns

    @property
    def centres(self):
        row, column = np.indices(self.shape).reshape(2, -1)
        return self.low[:, None] + (np.stack([column, row]) + 0.5) * self.cell

    def look_up(self, uv):
        """The cell (n,) that holds each of uv (2,n), -1 off the raster; the cell (n,) that is nearest; the cells (4,n)
        round it, and their shares (4,n) of what is between their centres."""
        rows, columns = self.shape
        x, y = (uv - self.low[:, None]) / self.cell
        inside = (x >= 0) & (x < columns) & (y >= 0) & (y < rows)
        x, y = (np.clip(np.nan_to_num(v, nan=-1), 0, side * (1 - 1e-12)) for v, side in ((x, columns), (y, rows)))
        own = np.where(inside, y.astype(np.int64) * columns + x.astype(np.int64), -1)
        nearest = np.where(inside, own, y.astype(np.int64) * columns + x.astype(np.int64))
        x, y = np.clip(x - 0.5, 0, columns - 1), np.clip(y - 0.5, 0, rows - 1)
        j, i = np.minimum(x.astype(np.int64), max(columns - 2, 0)), np.minimum(y.astype(np.int64), max(rows - 2, 0))
        fx, fy = x - j, y - i
        right, up = min(1, columns - 1), columns if rows > 1 else 0
        first = i * columns + j
        around = np.stack([first, first + right, first + up, first + right + up])
        return own, nearest, around, np.stack([(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy])
