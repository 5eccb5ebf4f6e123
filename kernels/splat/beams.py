"""Exact coverage: each water triangle's beam is shared among the texels by the area that its image covers.

Rays through a triangle's corners and the middles of its edges land on the receivers. Where all six land on one of them
and the image is affine to within a fraction of a texel, the beam's flux is spread evenly over the image in UV space and
deposited by exact area coverage (`coverage.py`): folds, flips and overlaps need no special case, there is no noise, and
the flux is kept. Elsewhere - on the border of a chart, of an object or of a shadow, or where the map bends - the
triangle is split in four. A part of a texel's size that straddles a border is cut there (`border.py`); the few that
straddle more than one land point by point.
"""

from __future__ import annotations

import numpy as np

from ..halfedges import AFTER
from .border import cut, straddlers
from .lander import LOST, SHADOWED

# texels: larger parts are split even where all six rays agree, lest something lies between them; more so where they hit
# nothing, since a surface along the light is thin
_SIGHT, _SIGHT_LOST = 6.0, 3.0
_CUT = 1.0  # texels: parts smaller than this that straddle one border are cut there
_POINT = 0.25  # texels: parts smaller than this that straddle more land point by point
_DEPTH = 14  # splits at most
_FINE = 8  # images that bend by more than this part of the tolerance are spread in four parts
_WHOLE = [0, 1, 2]
_PARTS = ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])  # of corners 0, 1, 2 and the middles 3, 4, 5 of their edges
_EDGES = [0, 3, 1, 4, 2, 5, 3, 4, 5], [3, 1, 4, 2, 5, 0, 4, 5, 3]  # between which the parts' middles 6 to 14 lie
_MIDDLES = ([6, 14, 11], [7, 8, 12], [13, 9, 10], [12, 13, 14])  # of the parts' edges


def splat(lit, twins, lander, shadowed, sheet, texel_area, tolerance):
    """Leave the flux [W for 1 W/m^2] of all beams on a Sheet; returns {cause: W} of what reaches no receiver.

    lit: LitWater; twins (3T,); shadowed (T,) bool from `may_be_shadowed`; texel_area [m^2] of the finest map; tolerance
    [texel] within which a beam's image must be affine.
    """
    work = _Work(lander, sheet, tolerance, texel_area)
    ids = np.flatnonzero(lit.area)
    if not len(ids):
        return work.lost
    nodes, corner, middle = _first_nodes(lit, twins, lander, shadowed)
    corner, middle, area, shade = corner[ids], middle[ids], lit.area[ids], shadowed[ids]
    for depth in range(_DEPTH + 1):
        rest = work.settle(nodes, corner, middle, area, shade, depth == _DEPTH)
        if not len(rest):
            break
        nodes, corner, middle = _split(lander, nodes, corner[rest], middle[rest], shade[rest])
        area, shade = np.repeat(area[rest] / 4, 4), np.repeat(shade[rest], 4)
    return work.lost


def _first_nodes(lit, twins, lander, shadowed):
    """Nodes at the water's corners and the middles of its edges, and per triangle (T,3) which they are."""
    back, shade = lit.frame.T, np.repeat(shadowed, 3)
    half = np.arange(lit.triangles.size)
    if np.array_equal(lit.triangles, lit.normal_triangles):
        corner, m, n = lit.triangles.astype(np.int64), back @ lit.positions.T, back @ lit.normals.T
        owner = np.where((twins >= 0) & (twins < half), twins, half)  # of two half-edges the first has the node
    else:
        corner = half.reshape(-1, 3)
        m = back @ lit.positions[lit.triangles.ravel()].T
        n = back @ lit.normals[lit.normal_triangles.ravel()].T
        owner = half
    a, b = corner.ravel(), corner[:, AFTER].ravel()
    edges = np.flatnonzero(owner == half)
    middle = (np.cumsum(owner == half) - 1)[owner]
    count = m.shape[1]
    looked = [np.bincount(a, shade, minlength=count) > 0, np.bincount(middle, shade, minlength=len(edges)) > 0]
    a, b = a[edges], b[edges]
    m, n = (np.concatenate([v, (np.take(v, a, axis=1) + np.take(v, b, axis=1)) / 2], 1) for v in (m, n))
    return lander.land(m, n, np.concatenate(looked)), corner, middle.reshape(-1, 3) + count


def _split(lander, nodes, corner, middle, shade):
    """Nodes, corners (4n,3) and middles (4n,3) of the four parts of each of n triangles."""
    count = len(corner)
    known = nodes.take(np.concatenate([corner, middle], 1).T.ravel())  # six rows of n
    m, n = (v.reshape(3, 6, count) for v in (known.m, known.n))
    fresh = [((v[:, _EDGES[0]] + v[:, _EDGES[1]]) / 2).reshape(3, -1) for v in (m, n)]
    landed = lander.land(*fresh, np.tile(shade, len(_EDGES[0])))
    joined = known.join(landed)
    row = np.arange(count)[:, None, None]
    parts = (np.array(_PARTS) * count + row).reshape(-1, 3)
    return joined, parts, (np.array(_MIDDLES) * count + row).reshape(-1, 3)


class _Work:
    """The sheet, the books, and what decides whether a triangle is ready."""

    def __init__(self, lander, sheet, tolerance, texel_area):
        self.lander, self.sheet, self.tolerance, self.texel_area = lander, sheet, tolerance, texel_area
        self.lost = dict.fromkeys((*LOST.values(), "reflected"), 0.0)

    def settle(self, nodes, corner, middle, area, shade, last):
        """Deposit the triangles that are ready; returns the indices of those to split."""
        six = np.concatenate([corner, middle], 1)
        chart = nodes.chart[six]
        same = (chart == chart[:, :1]).all(1)
        bent = np.maximum(_bend(nodes.x[six]), _bend(nodes.y[six]))
        size = np.sqrt(2 * area / self.texel_area)  # texels across the light
        lost = chart[:, 0] < 0
        whole = same & np.where(lost, size < _SIGHT_LOST, (bent <= self.tolerance) & (size < _SIGHT))
        cut, order = straddlers(chart)
        at = np.flatnonzero(cut & ~same & (size < _CUT))
        done = self._cut(nodes, np.take_along_axis(six[at], order[at], axis=1), area[at], shade[at])
        whole[at[done]] = True
        small = ~whole & (last | (size * nodes.spread[six].max(1) < _POINT))
        once = same & whole & ~lost
        fine = once & (bent > self.tolerance / _FINE)
        for k, share, take in ((_WHOLE, 1, once & ~fine), *((part, 4, fine) for part in _PARTS)):
            take = np.flatnonzero(take)
            self._spread(nodes.take(six[take[:, None], k].T.ravel()), area[take] / share)
        at = np.flatnonzero(small | (same & whole & lost))
        self._points(nodes.take(six[at].ravel()), np.repeat(area[at] / 6, 6))
        return np.flatnonzero(~(whole | small))

    def _spread(self, corners, area):
        """Spread beams of area (n,) over the triangles of Nodes corners (3n,): first, second, third corners."""
        x, y = corners.x.reshape(3, -1).T, corners.y.reshape(3, -1).T
        chart, passed = corners.chart[: len(area)], corners.passed.reshape(3, -1).mean(0)
        landed = chart >= 0
        self.sheet.add_triangles(chart[landed], x[landed], y[landed], (area * passed)[landed])
        self._book(chart, area, passed)

    def _points(self, nodes, area):
        """Land beams of area (n,) as points."""
        landed = nodes.chart >= 0
        flux = area * nodes.passed
        self.sheet.add_points(nodes.chart[landed], nodes.x[landed], nodes.y[landed], flux[landed])
        self._book(nodes.chart, area, nodes.passed)

    def _book(self, chart, area, passed):
        """Book what is reflected of beams of area (n,), and what of them lands on no chart."""
        for code, cause in LOST.items():
            of_it = chart == code
            self.lost[cause] += (area[of_it] * (1.0 if code == SHADOWED else passed[of_it])).sum()
        self.lost["reflected"] += (area * (1 - passed))[chart != SHADOWED].sum()

    def _cut(self, nodes, six, area, shade):
        """Cut triangles six (n,6), lone corner first, at their border; returns whether (n,) that could be done."""
        ((s, near_s, far_s), (t, near_t, far_t)), sound = cut(self.lander, nodes, six, shade)
        lone, second, third = (nodes.take(six[:, k]) for k in range(3))
        pieces = (
            ((lone, near_s, near_t), s * t),
            ((far_s, second, third), 1 - s),
            ((far_s, third, far_t), s * (1 - t)),
        )
        take = np.flatnonzero(sound)
        for corners, share in pieces:
            first, *others = (c.take(take) for c in corners)
            self._spread(first.join(others[0]).join(others[1]), (area * share)[take])
        return sound


def _bend(v):
    """Largest distance (n,) of the middles v[:, 3:] of edges from the middles of the corners v[:, :3]."""
    off = [np.abs(v[:, 3 + k] - (v[:, k] + v[:, (k + 1) % 3]) / 2) for k in range(3)]
    return np.maximum(np.maximum(off[0], off[1]), off[2])
