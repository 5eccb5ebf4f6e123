"""What a few points in each cell of the entry find: where the light of each code goes, and how it had best be landed.

Where neighbouring rays go different ways, and do so round about, there is no sheet of light that beams could follow:
more points do better, and as nothing is left out between them they keep the flux. How many a cell gets is such that a
ray more brings the same anywhere; where the pilot's are as many they land it. Beams land the rest: smooth light, and
its outlines, which are one cell wide. What a cell gets is decided by those about it and never by its own few points:
else light that they happen to miss would be lost, and what they happen to find kept. So what is found alone is landed
as it was found.
"""

from __future__ import annotations

import numpy as np

from .codes import MOST

ALONG = 2  # points along the side of a cell
PILOT, POINTS, BEAMS = 0, 1, 2
_ROUGH = 6  # of eight cells: so many around a cell are to be mixed
_SIDES = np.array([3, 4, 6, 8, 12, 16, 24, 32, 48, 64])  # points along the side of a cell: few steps seldom change
_HALVINGS = 40


class Pilot:
    """code, path, end, cell (k,) of points, end being a number for what they end on; light (k,): the irradiance on a
    texel that each brings if it has that one for itself; flux (k,); entry: the `entry.Entry`. most: squared error that
    points may leave.

    kind (k,): what lands each point's light, PILOT, POINTS or BEAMS; error: what points are expected to leave.
    """

    def __init__(self, code, path, end, cell, light, flux, entry, most):
        self._entry, self._count = entry, len(entry.lit.area) // 2
        words, of_word = np.unique(code, return_inverse=True)
        strong = np.argsort(-np.bincount(of_word, flux, len(words)), kind="stable")[:MOST]
        number = np.full(len(words), -1)
        number[strong] = np.arange(len(strong))  # the pilot lands what more codes have than can be followed at once
        self._words, own = words[strong].tolist(), number[of_word]
        self._kind = np.full((len(strong) + 1, self._count), PILOT)
        self._side = np.zeros((len(strong), self._count), np.int64)
        self._torn, self._found, self._rough = np.zeros((3, len(strong), self._count), bool)
        self._light = np.zeros((len(strong), self._count))
        noise = np.zeros((len(strong), self._count))
        order = np.argsort(own, kind="stable")
        for k, at in enumerate(np.split(order, np.searchsorted(own[order], np.arange(len(strong))))[1:]):
            self._sort(k, path[at], end[at], cell[at], light[at])
            noise[k] = np.bincount(cell[at], light[at] ** 2, self._count)
        self.error = self._choose(noise, most) + (light[own < 0] ** 2).sum()
        self.kind = self._kind[own, cell]

    def _sort(self, k, path, end, cell, light):
        """Find out where light of code k is mixed, rough or smooth."""
        hits = np.bincount(cell, minlength=self._count)
        mixed = (hits > 0) & ((hits < ALONG**2) | self._parted(cell, path))
        beside = self._beside(mixed)
        self._torn[k] = mixed | (beside > 0) | (self._entry.around(self._parted(cell, end)) > 0)
        rough = self._rough[k] = beside >= _ROUGH
        self._light[k] = np.where(rough, self._beside(np.bincount(cell, light, self._count)) / 8, 0.0)
        self._found[k] = (hits > 0) & ~rough
        self._kind[k] = np.where(rough, POINTS, np.where(self._found[k] & self._near(k), BEAMS, PILOT))

    def _beside(self, values):
        """Sums (n,) of values (n,) over the eight cells round each."""
        return self._entry.around(values) - values

    def _near(self, k):
        """Whether (n,) code k was found within two cells of each, itself not counted: what is found by chance, alone,
        stands for what is not."""
        found = self._found[k].astype(np.int64)
        return self._entry.around(self._entry.around(found)) > self._entry.around(np.ones_like(found)) * found

    def _parted(self, cell, number):
        """Whether (n,) points of a cell (k,) differ by a number (k,)."""
        first = np.zeros(self._count, number.dtype)
        first[cell] = number
        return np.bincount(cell, number != first[cell], self._count) > 0

    def _choose(self, noise, most):
        """Set how many points land rough light, and where that is the pilot's matter; returns their error, which is
        `most` or, where that cannot be, the least."""
        at = np.nonzero(self._kind[:-1] == POINTS)
        rays = np.frexp(np.array([*self._words, 1], float))[1][at[0]] + 1
        light, noise = self._light[at], noise[at]

        def given(worth):
            points = light / np.sqrt(worth * rays)
            side = _SIDES[np.minimum(np.searchsorted(_SIDES**2, points), len(_SIDES) - 1)]
            side = np.where(points <= ALONG**2, 0, side)
            return side, np.where(side > 0, light**2 / np.maximum(side, 1) ** 2, noise).sum()

        low, high = -80.0, 80.0  # of the logarithm of the squared error that a ray more takes away
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if given(np.exp(middle))[1] <= most else (low, middle)
        side, error = given(np.exp(low))
        self._side[at] = side
        self._kind[at] = np.where(side > 0, POINTS, PILOT)
        return error

    def points(self):
        """How many points (n,) along the side of each cell, 0 for none, and the codes whose light they land in it: a
        list of words, and (n,) of bits."""
        used = np.flatnonzero(self._side.any(1))
        want = (1 << np.arange(len(used))) @ (self._side[used] > 0)
        return self._side.max(0, initial=0), [self._words[k] for k in used], want.astype(np.int64)

    def beams(self):
        """Codes that beams land, and for each one the cells (n,) that they start from - those near which it was found
        and which are not left to points - and where (n,) some of it may hide between their rays."""
        for k, word in enumerate(self._words):
            cells = self._near(k) & ~self._rough[k]
            if cells.any():
                beside = self._entry.around(self._found[k]) > 0
                yield word, cells, np.where(self._found[k], self._torn[k], beside)
