"""Where light sets out towards the casters: cells of a plane across a sun, above everything, or of a cube round a lamp.

The cells are those on which something that is looked for may lie, as the light sees it. They are handed on as if they
were water that bends nothing, so that beams and points start on them as on water. They lie on a lattice that stays
where it is from frame to frame, so that what does not move is met by the same rays.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from ..chance import uniform
from ..halfedges import build_twins
from ..lit_water import cut_behind, in_perspective, light_water
from ..maps.uv_raster import touching
from ..optics import sun_frame
from ..scene import Sun, Water
from .places import keys
from .steady import no_larger, step

BLOCK = 1 << 16  # points at once: enough that a call costs more than its start even when few of them go on
_APART = 1 << 20  # more columns than a plane has cells
_TINY = np.finfo(float).tiny
_NEAR = 1e-6  # of the farthest point: what is nearer to the lamp than that is not looked for
_LEAST = 1e-9  # of how far off it is: the size of a cell
CELLS = 32, 256  # along the longer side of a plane, at least and at most
_PARTS = 16  # of a step of the bounds: places of points
_ABOVE = 1e-3  # of the extent: how far above everything a sun's light sets out
_ABOVE_STEPS = 1 / 16  # of a step of all there is: what that is rounded up to
_ASIDE = 1 / np.pi  # of a cell: edges of what is modelled at round numbers lie on no edge of cells


class Entry:
    """The cells (n,) of a light from which it may meet triangles soup (T,3,3).

    everything (V,3): all positions of the scene; width [m] that cells are to have where what is seen is, within reason.
    lit: their LitWater; cell (2n,) that each of its triangles is in; place (2,n): columns and rows of cells, those of
    each plane apart.
    """

    def __init__(self, light, soup, everything, width):
        if isinstance(light, Sun):
            frame = sun_frame(light.direction)
            local = everything @ frame.T
            low, high = local.min(0), local.max(0)
            fine = step(low, high) * _ABOVE_STEPS
            top = np.ceil((high[2] + _ABOVE * (high - low).max()) / fine) * fine
            views = [(frame, (soup @ frame.T)[:, :, :2], np.array([0, 0, top]), np.inf)]
        else:
            views = [(f, _seen(light.position, soup, f), f @ light.position - [0, 0, 1], 1.0) for f in _cube()]
        apart = None if isinstance(light, Sun) or not len(soup) else np.ptp(soup, axis=(0, 1)).max()
        self._settle(light, [_Face(*view, width, apart) for view in views if len(view[1])])
        at = self.lit.points if len(self.lit.points) else np.zeros((1, 3))
        self._part = step(at.min(0), at.max(0)) / _PARTS

    def _settle(self, light, faces):
        self._light, self._faces = light, faces
        parts = [face.mesh() for face in self._faces]
        bases = np.cumsum([0, *(len(p[0]) for p in parts)])
        positions, normals = (np.concatenate([np.zeros((0, 3)), *(p[k] for p in parts)]) for k in (0, 2))
        triangles = np.concatenate([np.zeros((0, 3), np.int64), *(p[1] + b for p, b in zip(parts, bases))])
        self.cell = np.arange(len(triangles)) // 2
        apart = [np.array([[k * _APART], [0]]) for k in range(len(self._faces))]
        self.place = np.concatenate(
            [np.zeros((2, 0), np.int64), *(f.place() + a for f, a in zip(self._faces, apart))], 1
        )
        twins = build_twins(triangles)
        self.lit = light_water(Water("Entry", positions, triangles, normals, triangles, twins), light)

    def keys(self, m):
        """Numbers (k,) of points m (3,k), see `places.keys`, that stay the same while things move."""
        return keys(m, self._part)

    def around(self, values):
        """Sums (n,) of values (n,), numbers or bools, over each cell and its eight neighbours."""
        return np.concatenate([np.zeros(0, np.int64), *(face.around(part) for face, part in self._by_face(values))])

    def finer(self, chosen):
        """The Entry of those cells alone that are chosen (n,) bool, each cut in four."""
        entry = copy(self)
        entry._settle(self._light, [face.finer(part) for face, part in self._by_face(chosen)])
        return entry

    def _by_face(self, values):
        """Faces, each with those of values (n,) that are of its cells."""
        cuts = np.cumsum([len(face.row) for face in self._faces])[:-1]
        return zip(self._faces, np.split(values, cuts) if self._faces else (), strict=True)


def evenly(lit, photons):
    """How many points (n,) along the side of each cell of a LitWater of cells make about `photons` in all, and one at
    least in each that has an area."""
    area = _areas(lit)
    return np.ceil(np.sqrt(area * (photons / max(area.sum(), _TINY))) - 1e-9).astype(np.int64)


def points(lit, side, place, seed):
    """Yield cells (n,), strata (2,n), points m (3,n) on them, in the world, and the area (n,) of each, over a LitWater
    of cells that lie at place (2,cells): jittered in each of side by side parts of a cell, side (cells,), by its place
    and the seed alone.

    Strata of cells with as many points are numbered through, those of others are apart.
    """
    area = _areas(lit)
    side = np.where(area > 0, side, 0)
    for k in np.unique(side[side > 0]).tolist():
        group, step = np.flatnonzero(side == k), max(1, BLOCK // (k * k))
        inner = np.stack(np.divmod(np.arange(k * k), k))[:, None]
        for start in range(0, len(group), step):
            block = group[start : start + step]
            a, b, c = (np.take(lit.points, lit.triangles[2 * block, j], axis=0).T[:, :, None] for j in range(3))
            stratum = place[:, block, None] * k + inner
            u, v = (inner + uniform(seed, np.full((1, 1), k), *stratum)) / k
            m = (a + u * (b - a) + v * (c - b)).reshape(3, -1)
            yield np.repeat(block, k * k), stratum.reshape(2, -1), m, np.repeat(area[block] / (k * k), k * k)


def _areas(lit):
    """Areas (cells,) of cells of a LitWater: one half of a cell may lie off a cone."""
    return 2 * lit.area.reshape(-1, 2).max(1)


class _Face:
    """Cells of one plane: frame (3,3), rows its axes x and y and the one back to the light; corners (T,3,2) of what is
    seen on it; origin (3,) of its coordinates, in the frame; it spans -reach to reach; width [m] of cells where what
    is seen is apart [m], None where that is what it is on the plane. row, column (n,) of its cells, by rows."""

    def __init__(self, frame, corners, origin, reach, width, apart):
        self._frame, self._origin = frame, origin
        low, high = (np.clip(v, -reach, reach) for v in (corners.min((0, 1)), corners.max((0, 1))))
        side = (high - low).max()
        cells = np.clip((side if apart is None else apart) / width, *CELLS)
        size = no_larger(max(side / cells, _LEAST * np.abs([low, high]).max(), _TINY), width)
        most, self._aside = np.inf, _ASIDE
        if np.isfinite(reach):  # an odd number of whole cells fills the face
            most, self._aside = np.ceil(reach / size), 0.5
            size = reach / (most + 0.5)
        first = np.maximum(np.floor(low / size - self._aside) - 1, -most - 1)
        last = np.minimum(np.ceil(high / size - self._aside) + 1, most)
        self._first, (columns, rows) = first.astype(np.int64), (last - first).astype(np.int64)
        self._columns, self._size = columns, size
        grid = np.zeros((max(columns, rows),) * 2, bool)
        grid.ravel()[touching(corners / size - self._aside - self._first, len(grid))[1]] = True
        self._keep(*np.nonzero(_around(grid[:rows, :columns])))

    def _keep(self, row, column):
        """Take the cells (n,) for its own, and look up the nine (9,n) about each, n where there is none."""
        self.row, self.column = row, column
        wide = column.max(initial=0) + 3
        key = row * wide + column + 1
        about = (key + np.arange(-1, 2)[:, None, None] * wide + np.arange(-1, 2)[:, None]).reshape(9, -1)
        found = np.searchsorted(key, about)
        self._about = np.where(np.append(key, -1)[found] == about, found, len(key))

    def around(self, part):
        """As `Entry.around`, of this face's cells."""
        part = np.append(part.astype(np.int64) if part.dtype == bool else part, part.dtype.type(0))
        return sum(part.take(own) for own in self._about)

    def finer(self, chosen):
        """The face with those cells alone that are chosen (n,) bool, each cut in four."""
        face, half = copy(self), np.arange(4)[:, None]
        row, column = 2 * self.row[chosen] + half // 2, 2 * self.column[chosen] + half % 2
        order = np.lexsort((column.ravel(), row.ravel()))
        face._keep(row.ravel()[order], column.ravel()[order])
        face._columns, face._size = 2 * self._columns, self._size / 2
        face._first, face._aside = 2 * self._first, 2 * self._aside
        return face

    def place(self):
        """Column and row (2,n) of the cells, on a lattice that stays where it is while things move."""
        return np.stack([self.column, self.row]) + self._first[:, None]

    def mesh(self):
        """Positions (V,3), triangles (2n,3) and normals (V,3) of the cells."""
        first = self.row * (self._columns + 1) + self.column
        quad = np.stack([first, first + 1, first + self._columns + 2, first + self._columns + 1], 1)
        used, index = np.unique(quad, return_inverse=True)
        y, x = np.divmod(used, self._columns + 1)
        x, y = (
            ((v + f + self._aside) * self._size + o)[:, None] for v, f, o in zip((x, y), self._first, self._origin[:2])
        )
        triangles = index.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
        positions = x * self._frame[0] + y * self._frame[1] + self._origin[2] * self._frame[2]
        return positions, triangles, np.tile(self._frame[2], (len(used), 1))


def _around(grid):
    """Whether any of a grid (rows, columns) is set in each cell and the eight round it."""
    framed = np.pad(grid, 1)
    return np.any([framed[j : j + grid.shape[0], i : i + grid.shape[1]] for j in range(3) for i in range(3)], 0)


def _cube():
    """Frames (3,3) of the faces of a cube about a lamp: each looks along its own -z."""
    return [sun_frame(axis) for axis in np.concatenate([np.eye(3), -np.eye(3)])]


def _seen(position, soup, frame):
    """Corners (n,3,2) of triangles soup (T,3,3) as a lamp sees them on the face at distance 1 along -z of a frame, of
    those that may lie on it."""
    local = (soup - position) @ frame.T
    nearest = _NEAR * np.abs(local).max(initial=0)
    corners = in_perspective(cut_behind(local, -nearest))[:, :, :2]
    return corners[((corners.max(1) > -1) & (corners.min(1) < 1)).all(1)]
