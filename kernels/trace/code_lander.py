"""Where light of some codes lands, for beams: as `splat.lander.Lander`, over casters and water in any order.

All codes are followed together: a point that several of them ask for is traced once, along the ways that they share.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from ..splat.lander import BACK, BEYOND, CULLED, FAINT, MISSED, OCCLUDED, OTHER, UNLIT, Nodes
from . import follow
from .codes import Codes
from .entry import BLOCK

_ENDS = np.full(6, OCCLUDED)  # charts, from the end, of what is no triangle; the first is of all triangles
_ENDS[[MISS, follow.BEYOND, follow.CULLED, follow.BLOCKED, follow.FAINT]] = MISSED, BEYOND, CULLED, OCCLUDED, FAINT
_PATHS = 1 << 20  # charts times paths that have numbers of their own, at most
_ASKED = 1 << 17  # points at once
_STRICT = 1e-3  # of tolerances: one that is less asks for finer parts
_PLACE = 24  # bits of a point's place, eight for each axis
_POINT = 1e-200  # m: what is no larger is one place
_SPREAD = sum(((np.arange(256) >> k & 1) << 3 * k for k in range(8)), np.int64(0)).astype(np.uint64)  # bits, apart


class Rows:
    """What rays carry: what arrives in each of `count` channels, and what of the light takes this code."""

    absorbing, again, varies = True, False, True

    def __init__(self, count):
        self.count, self.total = count, count + 1

    def causes(self):
        return "reflected", "absorbed"

    def arriving(self, carried):
        return carried[: self.count]

    def passed(self, carried):
        return carried[-1]

    entered = passed

    def met(self, flux, _area):
        return flux[-1]


class CodeLander:
    """Follows the light of a `cast.Cast` whose paths have one of the codes `words`.

    A node's chart is that of the receiver for each path over smooth surfaces: beams whose rays differ in it are parts
    of different sheets of light. image: the receiver of each.
    """

    # Curved surfaces spread beams of two texels over many; what they turn back rises steeply towards their outline.
    certain, hides, grazing, again = False, True, True, 0

    def __init__(self, cast, words, brightness):
        self._cast, self._codes, self._brightness = cast, Codes(words), brightness
        self.fine = 1.0 if cast.settings.tolerance >= _STRICT else 0.5
        charts = cast.arrivals.image
        self._most = max(_PATHS // max(len(charts), 1), 1)
        self.image = np.tile(charts, self._most)
        self.rows = Rows(cast.channels)

    def weight(self, chart, x, y):
        """As `splat.lander.Lander.weight`: by how bright it is where the first of the rays lands that does."""
        first = (chart >= 0).argmax(0)[None]
        chart, x, y = (np.take_along_axis(v, first, axis=0)[0] for v in (chart, x, y))
        return self._brightness.at(np.take(self.image, np.maximum(chart, 0)), x, y)

    def land(self, m, n, number):
        """Nodes of points m (3,k) of the entry, in the world, each of the code of that number (k,)."""
        blocks = [slice(start, start + _ASKED) for start in range(0, m.shape[1], _ASKED)] or [slice(0)]
        parts = [vars(self._land(m[:, block], n[:, block], number[block])).values() for block in blocks]
        return Nodes(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))

    def _land(self, m, n, number):
        """As `land`, of one block."""
        order, starts, own = _alike(m)
        first = order[starts]
        want = np.bitwise_or.reduceat(np.left_shift(1, number[order]), starts) if len(order) else first
        record = np.zeros((len(first), len(self._codes.words)), np.int32)  # 0 for what does not come
        columns, count = [_none(self.rows.total)], 1
        for start in range(0, len(first), BLOCK):
            for point, code, *found in self._follow(m[:, first[start : start + BLOCK]], want[start : start + BLOCK]):
                record[start + point, code] = np.arange(count, count + len(point))
                columns.append(found)
                count += len(point)
        chart, x, y, spread, carried = (np.concatenate(part, axis=-1) for part in zip(*columns, strict=True))
        at = record.ravel().take(own * record.shape[1] + number)
        chart, carried = np.take(chart, at), np.take(carried, at, axis=1)
        chart[(at == 0) & (self._cast.met(m) == 0)] = UNLIT
        return Nodes(m, n, chart, *(np.take(v, at) for v in (x, y, spread)), carried)

    def _follow(self, m, want):
        """Yield points (k,), numbers of codes (k,), and chart, x, y, spread (k,) and carried (R,k) of what arrives from
        points m (3,n) that ask for codes want (n,)."""
        rays, met = self._cast.start(m)
        for ended, end in self._cast.ends(rays, self._codes, want):
            passed = ended.share * met[ended.photon]
            chart, spread = _ENDS[np.minimum(end, 0)], np.ones(len(end))
            (x, y), carried = np.zeros((2, len(end))), np.tile(passed, (self.rows.total, 1))
            landed = self._cast.landed(ended, end)
            at = landed.ray
            chart[at], x[at], y[at] = self._sheets(landed), landed.x, landed.y
            carried[: self.rows.count, at] *= landed.colour
            spread[at] = self._cast.spreads(m[:, landed.photon], landed.way)
            yield ended.photon, np.take(self._codes.number, ended.code), chart, x, y, spread, carried

    def _sheets(self, landed):
        """Charts (k,) of Landed rays, with a number of their path; BACK stays."""
        number = (landed.path >> 20) % self._most
        return np.where(landed.chart == BACK, BACK, landed.chart + len(self._cast.arrivals.image) * number)


def _none(rows):
    """chart, x, y, spread and carried of what does not come."""
    zero = np.zeros(1)
    return np.full(1, OTHER), zero, zero, np.ones(1), np.zeros((rows, 1))


def _alike(m):
    """An order (k,) of points m (3,k) in which those that are the same follow each other, and those near each other,
    so that their rays meet the same; where in it (u,) each other one starts, and which (k,) of these each point is."""
    key = np.zeros(m.shape[1], np.uint64)
    for row in m:
        key ^= np.ascontiguousarray(row).view(np.uint64)
        key ^= key >> np.uint64(32)
        key *= np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    key >>= np.uint64(_PLACE)
    key |= _place(m) << np.uint64(64 - _PLACE)
    order = np.argsort(key)
    ordered = key[order]
    new = np.concatenate([[True], ordered[1:] != ordered[:-1]])[: len(key)]
    own = np.empty(len(key), np.int64)
    own[order] = np.cumsum(new) - 1
    return order, np.flatnonzero(new), own


def _place(m):
    """Numbers (k,) of _PLACE bits of the places of points m (3,k), along Morton's curve."""
    if not m.size:
        return np.zeros(0, np.uint64)
    low, extent = m.min(1)[:, None], np.ptp(m, axis=1).max()
    cell = ((m - low) * (255 / extent if extent > _POINT else 0.0)).astype(np.int64)
    return sum(np.take(_SPREAD << np.uint64(k), cell[k]) for k in range(3))
