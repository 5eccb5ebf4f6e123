"""The water as if it lay still: its mean plane, and what of that plane it covers."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..halfedges import AFTER
from ..maps.coverage import edge_coverage
from ..maps.uv_raster import cross2

FINER = 2  # cells to a texel
_CELLS = 64, 1024  # along the longer side of the outline, at least and at most


class Still:
    """The plane nearest to a Water's vertices, by least squares, or that of a Level.

    frame (3,3): rows are two axes in it and its normal, upwards; origin (3,): a point on it; texel [m]: how finely the
    outline is to be known. Coordinates "in the plane" are frame (p - origin).
    """

    def __init__(self, water, texel, level=None):
        self.water, self.texel = water, texel
        if level is not None:
            self.origin, self.frame, self.rim = level.origin, level.frame, level.rim
            return
        self.origin = water.positions.mean(0)
        away = water.positions - self.origin
        axes = np.linalg.eigh(away.T @ away)[1]
        n = axes[:, 0] * (-1.0 if axes[2, 0] < 0 else 1.0)
        x = axes[:, 2]
        self.frame = np.stack([x, np.cross(n, x), n])

    def to_plane(self, p):
        """Coordinates (3,n) in the plane, the last one the height over it, of points p (n,3)."""
        return self.frame @ p.T - (self.frame @ self.origin)[:, None]

    def to_world(self, q):
        """Points (n,3) in the world of coordinates (3,n) in the plane."""
        return q.T @ self.frame + self.origin

    @cached_property
    def rim(self):
        """The `outline`, or the Level's."""
        return self.outline()

    def outline(self):
        """Ends (2,2,n), as end, axis, edge, of the outline's edges in the plane, counter-clockwise round the water.

        They are the edges without a neighbour; of a closed body of water, those between what faces up and what does
        not.
        """
        water = self.water
        half = np.flatnonzero(water.twins < 0)
        if not len(half):
            leaning = water.normals[water.normal_triangles] @ self.frame[2]
            up = leaning.sum(1) > 0
            half = np.flatnonzero(np.repeat(up, 3) & ~up[water.twins // 3])
        triangle, edge = np.divmod(half, 3)
        plan = (water.positions[water.triangles[triangle]] - self.origin) @ self.frame[:2].T
        turn = cross2(plan[:, 1] - plan[:, 0], plan[:, 2] - plan[:, 0])
        rank = np.arange(len(half))
        tail, head = plan[rank, edge], plan[rank, AFTER[edge]]
        back = (turn < 0)[:, None]
        ends = np.stack([np.where(back, head, tail).T, np.where(back, tail, head).T])
        return ends[:, :, turn != 0]

    @cached_property
    def _cells(self):
        """Share of cells (H,W) of a grid that is water, the grid's lowest corner (2,) and its cells' width [m]."""
        rim = self.rim
        low, high = rim.min((0, 2), initial=np.inf), rim.max((0, 2), initial=-np.inf)
        if not rim.size:
            return np.zeros((2, 2)), np.zeros(2), 1.0
        wide = (high - low).max()
        cell = wide / np.clip(np.ceil(FINER * wide / self.texel), *_CELLS)
        low = low - 1.5 * cell  # so that the first and the last cell are dry
        width, height = (np.ceil((high - low) / cell) + 2).astype(int)
        tail, head = (rim - low[:, None]) / cell
        share = edge_coverage(tail, head, np.ones((1, rim.shape[2])), (height, width))[0]
        return np.clip(share, 0, 1), low, cell

    def covered(self, x, y):
        """Share (n,) of water in a texel round points of the plane."""
        share, low, cell = self._cells
        steep = max(FINER * cell / self.texel, 1.0)  # where cells are coarser, from none to all within a texel still
        height, width = share.shape
        at = [
            np.clip((v - start) / cell - 0.5, 0, side - 1.001) for v, start, side in zip((x, y), low, (width, height))
        ]
        whole = [v.astype(np.int64) for v in at]
        (column, row), (along, up) = whole, (a - w for a, w in zip(at, whole))
        flat, first = share.ravel(), row * width + column
        below = (1 - along) * np.take(flat, first) + along * np.take(flat, first + 1)
        above = (1 - along) * np.take(flat, first + width) + along * np.take(flat, first + width + 1)
        return np.clip(((1 - up) * below + up * above - 0.5) * steep + 0.5, 0, 1)

    def area(self):
        """Area [m^2] of the plane that is water."""
        tail, head = self.rim
        return float((tail[0] * head[1] - tail[1] * head[0]).sum() / 2)

    def whole(self):
        """A point (3,1) of the plane and the area (1,) [m^2] of all water, for light that is the same all over."""
        return np.zeros((3, 1)), np.array([self.area()])

    def cells(self):
        """Points (3,n) of the plane and areas (n,) [m^2] of water round them that make up all of it."""
        share, low, cell = self._cells
        row, column = np.nonzero(share)
        x, y = np.stack([column + 0.5, row + 0.5]) * cell + low[:, None]
        return np.stack([x, y, np.zeros_like(x)]), share[row, column] * cell**2
