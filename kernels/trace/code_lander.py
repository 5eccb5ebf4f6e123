"""Where light of some codes lands, for beams: as `splat.lander.Lander`, over casters and water in any order.

All codes are followed together: a point that several of them ask for is traced once, along the ways that they share.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from ..splat.lander import BACK, BEYOND, CULLED, FAINT, MISSED, OCCLUDED, OTHER, UNLIT, Nodes
from . import follow
from .codes import Codes

_ENDS = np.full(8, OCCLUDED)  # charts, from the end, of what ends on none
_ENDS[[MISS, follow.BEYOND, follow.CULLED, follow.BLOCKED, follow.FAINT]] = MISSED, BEYOND, CULLED, OCCLUDED, FAINT
_ENDS[BACK] = BACK
_PATHS = 1 << 20  # charts times paths that have numbers of their own, at most
_ASKED = 1 << 17  # points at once
_STRICT = 1e-3  # of tolerances: one that is less asks for finer parts


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
        key = self._cast.entry.keys(m)
        order, starts, own = _alike(key)
        first = order[starts]
        want = np.bitwise_or.reduceat(np.left_shift(1, number[order]), starts) if len(order) else first
        ways = self._cast.follow_codes(m[:, first], key[first], self._codes, want)
        record = np.zeros((len(first), len(self._codes.words)), np.int32)  # 0 for what does not come
        record[ways.photon, ways.code] = np.arange(1, len(ways.code) + 1)
        columns = zip(_none(self.rows.total), self._found(m[:, first], ways), strict=True)
        chart, x, y, spread, carried = (np.concatenate(part, axis=-1) for part in columns)
        at = record.ravel().take(own * record.shape[1] + number)
        chart, carried = np.take(chart, at), np.take(carried, at, axis=1)
        chart[(at == 0) & (self._cast.met(m) == 0)] = UNLIT
        return Nodes(m, n, chart, *(np.take(v, at) for v in (x, y, spread)), carried)

    def _found(self, m, ways):
        """chart, x, y, spread (k,) and carried (R,k) of Ways of points m (3,n)."""
        landed = ways.chart >= 0
        number = (ways.path >> 20) % self._most
        chart = np.where(landed, ways.chart + len(self._cast.arrivals.image) * number, _ENDS[np.minimum(ways.chart, 0)])
        carried = np.tile(ways.share * np.take(self._cast.met(m), ways.photon), (self.rows.total, 1))
        carried[: self.rows.count] *= ways.colour
        spread = np.ones(len(chart))
        at = np.flatnonzero(landed | (ways.chart == BACK))
        spread[at] = self._cast.spreads(np.take(m, ways.photon[at], axis=1), ways.way[at])
        return chart, ways.x, ways.y, spread, carried


def _none(rows):
    """chart, x, y, spread and carried of what does not come."""
    zero = np.zeros(1)
    return np.full(1, OTHER), zero, zero, np.ones(1), np.zeros((rows, 1))


def _alike(key):
    """An order (k,) of points of keys (k,) in which those that are the same follow each other, and those near each
    other, so that their rays meet the same; where in it (u,) each other one starts, and which (k,) of these each is."""
    order = np.argsort(key)
    ordered = key[order]
    new = np.concatenate([[True], ordered[1:] != ordered[:-1]])[: len(key)]
    own = np.empty(len(key), np.int64)
    own[order] = np.cumsum(new) - 1
    return order, np.flatnonzero(new), own
