"""What a few points in each cell of the entry find: where the light of each code goes, and how it had best be landed.

Codes whose points leave little noise are landed by these very points. Of the others, cells in which neighbouring rays
go different ways, and whose neighbours are such cells too, are rough: there is no sheet of light that beams could
follow, and more points do better. The outline of a smooth thing is one cell wide; it is left to beams.
"""

from __future__ import annotations

import numpy as np

ALONG = 2  # points along the side of a cell
_ROUGH = 6  # of nine cells: so many around, and with, a cell are to be mixed


class Pilot:
    """found: (Rays, what they end on, their flux over the power, the cell that each is from), a list; receiving: how
    many triangles belong to receivers; entry: the `entry.Entry`; texel: area [m^2] of the smallest texel."""

    def __init__(self, found, receiving, entry, texel):
        self._entry, self._count = entry, len(entry.lit.area) // 2
        self._found = found
        parts = [(r.code, r.path, c, np.where((end >= 0) & (end < receiving), f, 0.0)) for r, end, f, c in found]
        none = [(np.zeros(0, np.int64),) * 3 + (np.zeros(0),)]
        self._code, self._path, self._cell, arrived = (np.concatenate(part) for part in zip(*none, *parts, strict=True))
        self.arrived = arrived.sum()
        self._noise = (arrived / texel) ** 2
        self.words, self._of = np.unique(self._code, return_inverse=True)
        self._flux = np.bincount(self._of, arrived, len(self.words))

    def flux(self, word):
        """Flux over the power that arrives by a code."""
        return self._flux[np.searchsorted(self.words, word)]

    def quiet(self, most):
        """The codes (k,) of the least noise, squared error [1] of their points, whose sum is no more than `most`; and
        that sum."""
        noise = np.bincount(self._of, self._noise, len(self.words))
        order = np.argsort(noise, kind="stable")
        chosen = order[np.cumsum(noise[order]) <= most]
        return self.words[chosen], noise[chosen].sum()

    def points(self, words):
        """Yield (Rays, what they end on, flux over the power) of the points that took one of the codes (k,)."""
        for rays, end, flux, _ in self._found:
            at = np.flatnonzero(np.isin(rays.code, words))
            yield rays.take(at), end[at], flux[at]

    def cells(self, word):
        """Where (n,) bool light of a code was found, and where it is rough."""
        own = np.flatnonzero(self._code == word)
        cell, path = self._cell[own], self._path[own]
        hits = np.bincount(cell, minlength=self._count)
        first = np.zeros(self._count, np.int64)
        first[cell] = path
        parted = np.bincount(cell, path != first[cell], self._count) > 0
        mixed = (hits > 0) & ((hits < ALONG**2) | parted)
        return hits > 0, mixed & (self._entry.around(mixed) >= _ROUGH)

    def noise(self, rough):
        """Squared error that the pilot's points would leave where light is rough: {code: (n,) bool}."""
        return sum(self._noise[(self._code == word) & cells[self._cell]].sum() for word, cells in rough.items())
