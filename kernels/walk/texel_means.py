"""Means over texels: all paths to sub-points of each, more of them where two independent draws disagree.

A draw puts strata^2 sub-points in every texel, each with the light of all its paths; where the water throws its light
together beams take over (`concentrated.py`), so that every contribution is bounded. Two draws give the mean and, by
their difference, its error. A texel is drawn again, with more sub-points, if its neighbours' errors ask for it: never
its own, which would favour draws that agree by chance.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .concentrated import focusing, throw_together
from .subpoints import SubPoints, SubTexels

_DECAY = 1.5  # measured: the error of a texel falls as its sub-points to this power
_AIM = 0.8  # of the tolerance, in a prediction
_BEAMS = 0.03  # of the tolerance, for what beams predict of theirs
_FEWEST = 1 << 12  # sub-points of a draw: chance deceives fewer
_MOST = 32  # strata along a texel's side
_ROUNDS = 6
_POINTS = 1 << 18  # sub-points at once, or as many as there are triangles: bounds the memory


class Means:
    """Means over the Texels of a Scene's receivers, of the light that LightPaths `lights` bring.

    objects: a Tracer over all that blocks light, receivers first; paths: a dict that counts them.
    After `solve`: some, seen, missing (K,) bool, of texels that light leads to, in sight or not, and that miss paths.
    """

    def __init__(self, scene, texels, lights, objects, paths):
        self._scene, self._texels, self._objects, self._paths = scene, texels, objects, paths
        self._parts = [SubTexels(r, t) for r, t in zip(scene.receivers, texels, strict=True)]
        self._cuts = np.cumsum([0, *(len(t.texel) for t in texels)])
        self._area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
        self._lights = [(paths, self._focusing(paths)) for paths in lights]
        self.some, self.seen, self.missing = (np.zeros(len(self._area), bool) for _ in range(3))

    def solve(self, tolerance, seed):
        """Irradiance (K,3) within the relative mean squared error `tolerance`, and the error that it has."""
        even, known = self._thrown_together(_BEAMS * tolerance)
        strata = np.full(len(self._area), min(int(np.ceil(np.sqrt(_FEWEST / max(len(self._area), 1)))), _MOST))
        halves = np.zeros((2, len(self._area), 3))
        chosen = strata
        for round_ in range(_ROUNDS):
            drawn = self._draw(chosen, np.random.default_rng([seed, round_]))
            halves = np.where(chosen[:, None] > 0, drawn, halves)
            squares = ((halves[0] - halves[1]).mean(1) / 2) ** 2
            power = (self._area @ (even + halves.mean(0)).mean(1)) ** 2 / max(self._area.sum(), np.finfo(float).tiny)
            error = known + (self._area @ squares / power if power > 0 else 0.0)
            if error <= tolerance or round_ == _ROUNDS - 1:
                break
            wanted = self._wanted(strata, squares, (tolerance - known) * power)
            chosen = np.where(wanted > strata, wanted, 0)
            if not chosen.any():
                break
            strata = np.maximum(strata, wanted)
        self._paths["sub_points"] = self._paths.get("sub_points", 0) + int(2 * (strata**2).sum())
        return even + halves.mean(0), float(error)

    def _thrown_together(self, tolerance):
        """Irradiance (K,3) that beams bring, and its relative mean squared error."""
        flux, error = np.zeros((len(self._area), 3)), 0.0
        for paths, beams in self._lights:
            own, doubt = throw_together(self._scene, self._texels, self._objects, paths, beams, tolerance)
            flux, error = flux + own, max(error, doubt)
            self._paths["beams"] = self._paths.get("beams", 0) + np.count_nonzero(beams)
        self.some |= flux.any(1)
        self.seen |= flux.any(1)
        return flux / self._area[:, None], error

    def _wanted(self, strata, squares, allowed):
        """Strata (K,) of every texel with which the squared errors by area should sum to `allowed`, from the errors
        (K,) of its neighbours: fewest points in all where those of a texel are as (its error with one)^(1 / (1 + p)).
        """
        points = strata**2.0
        around = np.concatenate([_around(t, squares[part]) for t, part in self._each()])
        single = around * points**_DECAY
        low, high = np.log(max(single.max(initial=0), np.finfo(float).tiny)) - np.array([40.0, 0.0])
        for _ in range(30):
            middle = (low + high) / 2
            wanted = np.maximum((single / np.exp(middle)) ** (1 / (1 + _DECAY)), points)
            good = self._area @ (single * wanted**-_DECAY) <= _AIM * allowed
            low, high = (middle, high) if good else (low, middle)
        return np.clip(np.ceil(np.sqrt(wanted)), 1, _MOST).astype(np.int64)

    def _each(self):
        """The Texels of each receiver, and which of all texels they are."""
        return zip(self._texels, map(slice, self._cuts[:-1], self._cuts[1:]), strict=True)

    def _draw(self, strata, rng):
        """Irradiance (2,K,3) of texels with strata (K,) > 0, by two draws of strata^2 sub-points in each."""
        flux = np.zeros((2 * len(strata), 3))
        for paths, beams in self._lights:
            for k, (_, part) in enumerate(self._each()):
                for sub in self._blocks(k, strata[part], len(beams), rng):
                    self._search(paths, sub, beams, part, flux)
        return flux.reshape(2, -1, 3) / self._area[:, None]

    def _focusing(self, paths):
        """Whether (T,) triangles throw light together, of those that light meets from the front everywhere."""
        ids = paths.whole
        chosen = np.zeros(len(paths.lit.area), bool)
        for own in self._texels if len(ids) else ():
            chosen[ids] |= focusing(paths.grid(own.positions), ids, paths.lit.area[ids])
        return chosen

    def _blocks(self, k, strata, triangles, rng):
        """The SubPoints of receiver k in both draws, in blocks of texels; those of the second count from K."""
        total = np.cumsum(2 * strata**2)
        cuts = np.arange(max(_POINTS, triangles), total[-1] if len(total) else 0, max(_POINTS, triangles))
        cuts = [0, *np.searchsorted(total, cuts), len(strata)]
        for start, stop in pairwise(cuts):
            block = np.zeros(len(strata), np.int64)
            block[start:stop] = strata[start:stop]
            if block.any():
                one, other = (self._parts[k].draw(block, rng) for _ in range(2))
                other.texel += len(self._area)
                yield SubPoints.concatenated([one, other])

    def _search(self, paths, sub, beams, part, flux):
        """Add to flux (2K,3) what the paths to SubPoints bring through triangles that send no beams (T,)."""
        found = paths.to(sub.points, sub.normals)
        own = part.start + sub.texel
        texel = own[found.point]
        share = sub.area[found.point] * sub.scale[found.point] * found.density
        counts = np.flatnonzero(found.visible & ~beams[found.triangle])
        _add(flux, texel[counts], share[counts], paths.arriving(found.passed[counts], found.length[counts]))
        self.some[texel % len(self.some)] = True
        self.seen[texel[found.visible] % len(self.some)] = True
        self.missing[own[found.missing] % len(self.some)] = True
        for name, number in (("found", len(texel)), ("blocked", np.count_nonzero(~found.visible))):
            self._paths[name] = self._paths.get(name, 0) + number


def _add(flux, texel, share, watts):
    """Add share (n,) of watts (n,3) to flux (n,3) of texels (n,)."""
    for c in range(3):
        flux[:, c] += np.bincount(texel, share * watts[:, c], minlength=len(flux))


def _around(own, values):
    """Mean (K,) of values (K,) over the neighbours of each of the K texels, at most 24; the mean of all where it has
    none."""
    side, reach = own.resolution, 2
    total = np.zeros((2, side + 2 * reach, side + 2 * reach))
    row, column = np.divmod(own.texel, side)
    total[0, row + reach, column + reach], total[1, row + reach, column + reach] = values, 1
    shifts = range(2 * reach + 1)
    beside = sum(total[:, j : side + j, i : side + i] for j in shifts for i in shifts if not i == j == reach)
    value, count = beside[:, row, column]
    return np.where(count > 0, value / np.maximum(count, 1), values.mean() if len(values) else 0.0)
