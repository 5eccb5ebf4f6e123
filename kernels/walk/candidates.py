"""Which triangles of the water may send light to which points: those whose image holds the point, at its own depth.

Points lie in the cells of a grid over the plan (`plan.py`), sorted by layers of depth, rows and columns, so that what a
triangle's box covers of a row is one run of points. In a layer the box is that of the images at its top and bottom,
since rays are straight; then every pair is tried against the triangle's own image at the point's depth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .plan import Plan, net

_TRIANGLES = 1 << 12  # at once
_PAIRS = 1 << 14  # at once: what a pair touches stays in the second-level cache
_LAYERS = 32  # at most
_SAMPLE = 4096  # triangles that tell what is typical
_CELLS = 1 << 22  # at most, in all layers
_MARGIN, _SLACK = 1.25, 0.03  # on how far a net reaches past its triangle: a factor, and in barycentric coordinates
_SLACK_THOROUGH = 0.5


@dataclass
class Pairs:
    """Triangles and points (n,) that may belong together; a, b (n,) where the point lies in the image of the triangle,
    as barycentric coordinates of an image that is affine; folded (n,) bool, the image turns over within."""

    triangle: np.ndarray
    point: np.ndarray
    a: np.ndarray
    b: np.ndarray
    folded: np.ndarray


def candidates(grid, triangles, thorough=False):
    """Yield the Pairs, in blocks, of triangles (m,) of the Rays of a Grid and its points; thorough: look further round
    each triangle, and count every one as folded."""
    if not len(grid.order):
        return
    rays = grid.rays
    for start in range(0, len(triangles), _TRIANGLES):
        block = triangles[start : start + _TRIANGLES]
        lines = grid.lines(*rays.corner[block].T, *rays.middle[block].T)
        for layer in range(grid.layers):
            yield from _in_layer(grid, layer, block, lines, thorough)


class Grid:
    """Points p (3,n) in the plan of Rays, sorted into cells: order (n,) of the points; u, v, depth (n,) in that order;
    cell (n,) of each point; shape, layers x rows x columns; low (2,) and size of the cells."""

    def __init__(self, rays, p):
        self.rays, self._plan = rays, Plan(rays, p)
        self.flat = self._plan.flat
        self._a, self._drift = self._plan.lines()
        self._place(*self._plan.points(p))

    def _place(self, u, v, depth):
        low, high = (np.array([f(c, initial=0) for c in (u, v)]) for f in (np.min, np.max))
        top, bottom = depth.min(initial=0), depth.max(initial=0)
        image, speed = self._typical()
        layers = np.ceil((bottom - top) * speed / max(image, np.finfo(float).tiny))
        self.layers = 1 if self.flat else int(np.clip(layers, 1, _LAYERS))
        spacing = np.sqrt(max(np.prod(high - low), np.finfo(float).tiny) / max(len(u), 1))
        self.size = max(image / 4, spacing, (high - low).max() * np.sqrt(self.layers / _CELLS), np.finfo(float).tiny)
        self.low = low
        self._nu, self._nv = (int((high[k] - low[k]) / self.size) + 1 for k in (0, 1))
        self.shape = self.layers, self._nv, self._nu
        thick = (bottom - top) / self.layers
        self.ends = top + thick * np.arange(self.layers), top + thick * np.arange(1, self.layers + 1)
        layer = np.minimum((depth - top) / max(thick, np.finfo(float).tiny), self.layers - 1).astype(np.int64)
        row, column = ((c - c0) / self.size for c, c0 in ((v, low[1]), (u, low[0])))
        self.cell = (layer * self._nv + row.astype(np.int64)) * self._nu + column.astype(np.int64)
        self.order = np.argsort(self.cell, kind="stable")
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(self.cell, minlength=np.prod(self.shape)))])
        self.u, self.v, self.depth = u[self.order], v[self.order], depth[self.order]

    def _typical(self):
        """Side of a triangle's image and how fast images drift with depth, both typical."""
        corner = self.rays.corner[:: max(1, len(self.rays.corner) // _SAMPLE)]
        if not len(corner):
            return 0.0, 0.0
        spread = np.ptp(self._a[:, corner], axis=2).max(0)
        speed = np.abs(self._drift[:, corner[:, 0]]).max(0)
        return float(np.median(spread)), float(np.quantile(speed, 0.9))

    def lines(self, *rays):
        """A and B of rays, arrays (n,) of them: four rows, A_u, A_v, B_u, B_v, of one array each."""
        return [[np.take(line, k) for k in rays] for line in (*self._a, *self._drift)]

    def depth_of(self, points):
        """Depth (n,) of points (3,n)."""
        return self._plan.points(points)[2]

    def images(self, lines, layer):
        """Images, at the top and bottom of a layer, of triangles with `lines` of their corners and middles."""
        return [Image(*at_depth(lines, depth)) for depth in sorted({end[layer] for end in self.ends})]

    def near(self, images, layer, slack=_SLACK, cells=0):
        """Runs of points in the cells that the boxes round `images`, and so many `cells` round these, touch: box, first
        point and length of each."""
        low, high = np.minimum.reduce([i.low() for i in images]), np.maximum.reduce([i.high() for i in images])
        slack = slack * (high - low) + cells * self.size
        return self._runs(layer, low - slack, high + slack)

    def _runs(self, layer, low, high):
        """As `near`, for boxes low..high (2,n)."""
        begin = np.maximum(np.floor((low - self.low[:, None]) / self.size), 0)
        end = np.floor((high - self.low[:, None]) / self.size)
        end = np.minimum(end, np.array([[self._nu - 1], [self._nv - 1]]))
        rows = np.where((end >= begin).all(0), end[1] - begin[1] + 1, 0).astype(np.int64)
        box = np.repeat(np.arange(len(rows)), rows)
        row = np.arange(len(box)) - np.repeat(np.cumsum(rows) - rows, rows)
        row = (row + np.take(begin[1].astype(np.int64), box) + layer * self._nv) * self._nu
        first = np.take(self._starts, row + np.take(begin[0].astype(np.int64), box))
        length = np.take(self._starts, row + np.take(end[0].astype(np.int64), box) + 1) - first
        some = np.flatnonzero(length)
        return box[some], first[some], length[some]


def _in_layer(grid, layer, block, lines, thorough):
    """The Pairs of a block of triangles with the points of one layer."""
    shapes = grid.images(lines, layer)
    box, first, length = grid.near(shapes, layer, _SLACK_THOROUGH if thorough else _SLACK)
    if not len(box):
        return
    reach = np.maximum.reduce([shape.reach() for shape in shapes])
    folded = np.logical_or.reduce([shape.folded() for shape in shapes])
    folded |= np.sign(shapes[0].area) != np.sign(shapes[-1].area)
    folded |= thorough
    reach[:, folded] = np.inf
    total = np.cumsum(length)
    cuts = np.searchsorted(total, np.arange(_PAIRS, total[-1], _PAIRS)) + 1
    table = [np.stack([c[0], c[1] - c[0], c[2] - c[0]]) for c in (lines[:2] if grid.flat else lines)]
    for start, stop in zip([0, *cuts], [*cuts, len(box)], strict=True):
        if stop > start:
            runs = box[start:stop], first[start:stop], length[start:stop]
            yield _test(grid, runs, table, reach, folded, block)


def at_depth(lines, depth):
    """u and v, a list of arrays each, at a depth of `Grid.lines`."""
    return [[a + depth * b for a, b in zip(lines[k], lines[k + 2], strict=True)] for k in (0, 1)]


class Image:
    """Images of triangles at one depth, from the six Bezier points of each: x, y lists of 6 arrays."""

    def __init__(self, x, y):
        self.x, self.y = ([*c[:3], *net(*c[:3], c[3:])] for c in (x, y))
        self.area = self._cross(0, 1, 0, 2)

    def low(self):
        return np.stack([np.minimum.reduce(self.x), np.minimum.reduce(self.y)])

    def high(self):
        return np.stack([np.maximum.reduce(self.x), np.maximum.reduce(self.y)])

    def _cross(self, i, j, k, m):
        x, y = self.x, self.y
        return (x[j] - x[i]) * (y[m] - y[k]) - (y[j] - y[i]) * (x[m] - x[k])

    def jacobian(self):
        """Bezier coefficients, six arrays (n,), of the Jacobian: twice the area of the image per area of the triangle,
        between the least and the greatest of them everywhere."""
        # Differences along the first and second edge form nets of three; their cross products that of the Jacobian.
        first, second = ((0, 3), (3, 1), (5, 4)), ((0, 5), (3, 4), (5, 2))
        cross = [[4 * self._cross(*i, *j) for j in second] for i in first]
        mixed = [(cross[i][j] + cross[j][i]) / 2 for i, j in ((0, 1), (1, 2), (2, 0))]
        return [cross[0][0], cross[1][1], cross[2][2], *mixed]

    def folded(self):
        """Whether (n,) the image may turn over."""
        values = self.jacobian()
        return np.minimum.reduce(values) * np.maximum.reduce(values) <= 0

    def reach(self):
        """How far (3,n), in each barycentric coordinate, the net may reach below zero."""
        x, y = self.x, self.y
        area = np.where(self.area == 0, np.finfo(float).tiny, self.area)
        reach = np.zeros((3, len(area)))
        for k in (3, 4, 5):
            a = ((x[k] - x[0]) * (y[2] - y[0]) - (y[k] - y[0]) * (x[2] - x[0])) / area
            b = ((x[1] - x[0]) * (y[k] - y[0]) - (y[1] - y[0]) * (x[k] - x[0])) / area
            reach = np.maximum(reach, -np.stack([1 - a - b, a, b]))
        return _MARGIN * reach + _SLACK


def _test(grid, runs, table, reach, folded, block):
    """The Pairs of runs of points whose point may lie in the triangle's image."""
    box, first, length = runs
    own = np.repeat(box, length)
    place = np.arange(len(own)) + np.repeat(first - (np.cumsum(length) - length), length)
    u, v = np.take(grid.u, place), np.take(grid.v, place)
    x, y = ([np.take(c, own) for c in rows] for rows in table[:2])
    if len(table) > 2:
        depth = np.take(grid.depth, place)
        for image, drift in zip((x, y), table[2:], strict=True):
            for k in range(3):
                image[k] = image[k] + depth * np.take(drift[k], own)
    u -= x[0]
    v -= y[0]
    area = x[1] * y[2] - y[1] * x[2]
    scale = 1 / np.where(area == 0, np.finfo(float).tiny, area)
    a = (u * y[2] - v * x[2]) * scale
    b = (x[1] * v - y[1] * u) * scale
    near = (a >= -np.take(reach[1], own)) & (b >= -np.take(reach[2], own)) & (a + b <= 1 + np.take(reach[0], own))
    near = np.flatnonzero(near)
    own = own[near]
    return Pairs(block[own], grid.order[place[near]], a[near], b[near], folded[own])
