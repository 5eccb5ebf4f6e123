"""Where something could hide between the rays of a beam: near the edges of things, as the light sees them.

A line across a triangle has one of its corners on either side. So where the rays of a beam agree on what they meet,
nothing lies between them unless two lines do: of those that are the border of a surface, or an edge at which one face
looks towards the light and the other away. All such edges are drawn, by the line that each is part of, on grids over
the plan, one for each slice of height. Beams that pass cells of no more than one line are clear.
"""

from __future__ import annotations

import numpy as np

_SLICES, _CELLS = 8, 192
_SAME = 1e-5  # of the extent, and of a right angle: lines that are closer are one
_FLAT = 1e-9  # 1 less the cosine between faces that are one plane
_MARGIN = 1.0  # cells: edges are drawn as points no further than half a cell apart, and beams bend a little
_FAR = np.iinfo(np.int16).max // 2
_TINY = np.finfo(float).tiny


class Silhouettes:
    """Outlines of triangles (S,3) over positions (V,3), for rays within a cone about their mean direction."""

    def __init__(self, positions, triangles):
        self._positions, self._triangles = positions, triangles
        v = positions[triangles]
        normal = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
        self._normal = normal / np.maximum(np.sqrt((normal**2).sum(1)), _TINY)[:, None]
        edges, one, other = _edges(triangles)
        flat = (other >= 0) & ((self._normal[one] * self._normal[other]).sum(1) > 1 - _FLAT)
        self._edges, self._one, self._other = edges[~flat], one[~flat], other[~flat]

    def near(self, m, direction, triangles):
        """Sums (T,3) over the outlines that the beams may pass between rays from points m (3,k) along unit directions
        (3,k), at the corners of triangles (T,3): of 1, of the line's number and of its square; see `lines`.

        None is left out, but for what beams bend beyond a cell of the grid.
        """
        edges = self._outlines(direction)
        if not len(edges) or not len(triangles):
            return np.zeros((len(triangles), 3), np.int64)
        return _near(_Grid(self._positions[edges], m, direction), 0, None, m, direction, triangles)

    def _outlines(self, direction):
        """The edges (n,2) that may be outlines for directions (3,k)."""
        mean = direction.mean(1)
        length = np.sqrt(mean @ mean)
        if length < 0.5:
            return self._edges
        mean /= length
        cosine = min(float((mean @ direction).min()), 1.0)
        sine = np.sqrt(1 - cosine**2) if cosine > 0 else 1.0
        facing = self._normal @ mean
        one, other = facing[self._one], facing[self._other]
        hidden = ((one > sine) & (other > sine)) | ((one < -sine) & (other < -sine))
        return self._edges[~hidden | (self._other < 0)]


def lines(sums):
    """Whether (n,) sums (n,3) of `Silhouettes.near` are of one line at most: the mean square is the squared mean."""
    return sums[:, 0] * sums[:, 2] == sums[:, 1] ** 2  # modulo 2^64


def _near(grid, first, last, m, direction, triangles):
    """`Silhouettes.near` in the slices from `first` on and before `last`: in all of them as one, and where there is
    more than one line in either half."""
    last = grid.slices if last is None else last
    sums = grid.sums(first, last, m, direction, triangles)
    at = np.flatnonzero(~lines(sums))
    if last - first == 1 or not len(at):
        return sums
    used = np.zeros(m.shape[1], bool)
    used[triangles[at]] = True
    rest = m[:, used], direction[:, used], (np.cumsum(used) - 1)[triangles[at]]
    middle = (first + last) // 2
    sums[at] = _near(grid, first, middle, *rest) + _near(grid, middle, last, *rest)
    return sums


class _Grid:
    """Sums over the outlines' points, cumulated over slices of height and over the plan."""

    def __init__(self, ends, m, direction):
        low, high = ends[:, :, 2].min(), ends[:, :, 2].max()
        self._levels = np.linspace(low, high, _SLICES + 1 if high > low else 2)
        self.slices = len(self._levels) - 1
        reach = np.concatenate([_at(level, m, direction)[0] for level in (low, high)], 1)
        reach = np.concatenate([reach[:, np.isfinite(reach).all(0)], m[:2]], 1)
        self._low = np.maximum(reach.min(1), ends[:, :, :2].min((0, 1)))
        wide = np.minimum(reach.max(1), ends[:, :, :2].max((0, 1))) - self._low
        self._cell = np.maximum(wide.max(), _TINY) / _CELLS
        start, end, number = _clipped(ends, _numbers(ends), self._low, wide)
        points, parent = _points(start, end, self._cell, (high - low) / self.slices)
        column, row = np.clip((points[:, :2] - self._low) / self._cell, 0, _CELLS - 1).astype(np.int64).T
        level = np.clip((points[:, 2] - low) / max(high - low, _TINY) * self.slices, 0, self.slices - 1)
        sums = np.zeros((self.slices + 1, _CELLS + 1, _CELLS + 1, 3), np.int64)
        each = np.stack([np.ones(len(number), np.int64), number, number**2], 1)[parent]
        np.add.at(sums, (level.astype(np.int64) + 1, row + 1, column + 1), each)
        self._sums = sums.cumsum(0).cumsum(1).cumsum(2)

    def sums(self, first, last, m, direction, triangles):
        """`Silhouettes.near` in slices from `first` on and before `last`, by the box round the beams there."""
        sums = self._sums[last] - self._sums[first]
        if not sums[-1, -1, 0]:
            return np.zeros((len(triangles), 3), np.int64)
        box = self._box(first, last, m, direction)
        box = np.minimum(np.minimum(box[triangles[:, 0]], box[triangles[:, 1]]), box[triangles[:, 2]]).T
        x0, y0 = np.clip(box[:2], 0, _CELLS)
        x1, y1 = np.clip(1 - box[2:], 0, _CELLS)
        x1, y1 = np.maximum(x0, x1), np.maximum(y0, y1)
        return sums[y1, x1] - sums[y0, x1] - sums[y1, x0] + sums[y0, x0]

    def _box(self, first, last, m, direction):
        """First cells and, negated, last cells (k,4) that each ray passes in slices from `first` on and before `last`;
        none where it passes nowhere."""
        (low, behind), (high, over) = (_at(self._levels[k], m, direction) for k in (first, last))
        none = behind & over
        low, high = ((v.T - self._low).T / self._cell for v in (np.minimum(low, high), np.maximum(low, high)))
        box = np.concatenate([low, -high]) - _MARGIN
        box = np.floor(np.clip(box, -_FAR, _FAR)).astype(np.int16)
        box[:, none] = _FAR
        return np.ascontiguousarray(box.T)


def _at(level, m, direction):
    """Where in the plan (2,k) rays come to a height, and whether (k,) that lies behind them, when it is where they
    start."""
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.nan_to_num((level - m[2]) / direction[2], nan=np.inf, posinf=np.inf, neginf=-np.inf)
    behind = way <= 0
    way = np.minimum(np.where(behind, 0, way), 1 / _TINY**0.25)
    return m[:2] + way * direction[:2], behind


def _edges(triangles):
    """Edges (n,2) of triangles (T,3), with the triangles on one side and the other, -1 where there are not two."""
    half = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)
    key = half.min(1) * (int(triangles.max(initial=0)) + 1) + half.max(1)
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.concatenate([[True], np.diff(key[order]) != 0])) if len(key) else np.zeros(0, int)
    count = np.diff(first, append=len(key))
    second = order[np.minimum(first + 1, max(len(key) - 1, 0))] // 3
    return half[order[first]], order[first] // 3, np.where(count == 2, second, -1)


def _numbers(ends):
    """A number (n,) of the line that each of edges ends (n,2,3) is part of, the same for the same line."""
    middle = ends.mean((0, 1))
    start, along = ends[:, 0] - middle, ends[:, 1] - ends[:, 0]
    along = along / np.maximum(np.sqrt((along**2).sum(1)), _TINY)[:, None]
    main = np.take_along_axis(along, np.abs(along).argmax(1)[:, None], axis=1)
    along = along * np.sign(main)
    foot = start - (start * along).sum(1)[:, None] * along
    extent = max(np.abs(start).max(), _TINY)
    parts = np.rint(np.concatenate([along, foot / extent], 1) / _SAME).astype(np.int64)
    mixed = parts @ np.array([73856093, 19349663, 83492791, 49979687, 86028121, 15485863])
    return (mixed ^ (mixed >> 17)) & 0xFFFFF


def _clipped(ends, number, low, wide):
    """Ends (n,3) and (n,3), and numbers (n,), of the parts of edges ends (N,2,3) that lie over the plan's box from
    `low`, `wide` wide."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (low - start[:, :2]) / along[:, :2]
        last = (low + wide - start[:, :2]) / along[:, :2]
    level = along[:, :2] == 0
    inside = (start[:, :2] >= low) & (start[:, :2] <= low + wide)
    first, last = (
        np.where(level, np.where(inside, -np.inf, np.inf), np.minimum(first, last)),
        np.where(level, np.where(inside, np.inf, -np.inf), np.maximum(first, last)),
    )
    first, last = np.maximum(first.max(1), 0), np.minimum(last.min(1), 1)
    kept = first <= last
    start, along = start[kept], along[kept]
    return start + first[kept, None] * along, start + last[kept, None] * along, number[kept]


def _points(start, end, cell, height):
    """Points (n,3) along edges, half a cell and half a slice apart at most, and the edge (n,) of each."""
    along = end - start
    steps = np.abs(along) / np.array([cell, cell, max(height, _TINY)])
    count = (2 * np.where(np.isfinite(steps), steps, 0).max(1, initial=0)).astype(np.int64) + 2
    parent = np.repeat(np.arange(len(count)), count)
    rank = np.arange(len(parent)) - np.repeat(np.cumsum(count) - count, count)
    return start[parent] + (rank / (count - 1)[parent])[:, None] * along[parent], parent
