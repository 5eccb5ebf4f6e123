"""Where light of one code lands, for beams: as `splat.lander.Lander`, over casters and water in any order."""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from ..splat.lander import BACK, BEYOND, CULLED, MISSED, OCCLUDED, OTHER, UNLIT, Nodes
from . import follow
from .entry import BLOCK

_ENDS = {MISS: MISSED, follow.BEYOND: BEYOND, follow.CULLED: CULLED, follow.BLOCKED: OCCLUDED, follow.FAINT: OTHER}
_PATHS = 1 << 20  # charts times paths that have numbers of their own, at most


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
    """Follows the light of a `cast.Cast` whose paths have the code `word`.

    A node's chart is that of the receiver for each path over smooth surfaces: beams whose rays differ in it are parts
    of different sheets of light. image: the receiver of each. found (T,) bool: beams among which the pilot found it.
    """

    # Curved surfaces spread beams of two texels over many; what they turn back rises steeply towards their outline.
    certain, hides, grazing, again = False, True, True, 0

    def __init__(self, cast, word, found):
        self._cast, self._word, self._found = cast, word, found
        charts = cast.arrivals.image
        self._numbers, self._most = {}, max(_PATHS // max(len(charts), 1), 1)
        self.image = np.tile(charts, self._most)
        self.rows = Rows(cast.channels)

    def clear(self, _m, _n, _triangles, _shadowed):
        """Whether (T,) nothing hides between rays: where the pilot found no such light, as far as it tells."""
        return ~self._found

    def land(self, m, n, _shadowed):
        """Nodes of points m (3,k) of the entry, in the world."""
        blocks = [slice(start, start + BLOCK) for start in range(0, m.shape[1], BLOCK)] or [slice(0)]
        parts = [vars(self._land(m[:, block], n[:, block])).values() for block in blocks]
        return Nodes(*(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True)))

    def _land(self, m, n):
        """As `land`, of one block."""
        count = m.shape[1]
        rays, met = self._cast.start(m)
        chart, spread = np.full(count, OTHER), np.ones(count)
        chart[met == 0] = UNLIT
        (x, y), carried = np.zeros((2, count)), np.zeros((self.rows.total, count))
        for ended, end in self._cast.follower.ends(rays, self._word):
            at = ended.photon
            carried[:, at] = ended.share * met[at]
            chart[at] = np.where(end >= 0, OCCLUDED, MISSED)
            for code, own in _ENDS.items():
                chart[at[end == code]] = own
            landed = self._cast.landed(ended, end)
            at = landed.photon
            chart[at], x[at], y[at] = self._sheets(landed), landed.x, landed.y
            carried[: self.rows.count, at] *= landed.colour
            spread[at] = self._cast.spreads(m[:, at], landed.way)
        return Nodes(m, n, chart, x, y, spread, carried)

    def _sheets(self, landed):
        """Charts (k,) of Landed rays, with the number of their path; BACK stays."""
        paths, inverse = np.unique(landed.path, return_inverse=True)
        numbers = [self._numbers.setdefault(path, len(self._numbers) % self._most) for path in paths.tolist()]
        sheet = landed.chart + len(self._cast.arrivals.image) * np.array(numbers, np.int64)[inverse.reshape(-1)]
        return np.where(landed.chart == BACK, BACK, sheet)
