"""Means over texels: all paths to sub-points of each, more of them where two independent draws disagree.

A draw puts strata^2 sub-points in every texel, each with the light of all its paths; where the water throws its light
together photons take over (`concentrated.py`), so that every contribution is bounded and the mean is exact. Two draws
give the mean and, by their difference, its error. A texel is drawn again, with more sub-points, if its neighbours'
errors ask for it: never its own, which would favour draws that agree by chance.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .concentrated import Landing, focusing, throw
from .subpoints import SubTexels

_DECAY = 1.5  # measured: the error of a texel falls as its sub-points to this power
_AIM = 0.6  # of the tolerance, in a prediction
_MOST = 32  # strata along a texel's side
_ROUNDS = 6
_PHOTONS = 4.0  # to a sub-point, by area
_POINTS = 1 << 19  # sub-points at once, or as many as there are triangles: bounds the memory


class Means:
    """Means over the Texels of a Scene's receivers, of the light that LightPaths `lights` bring.

    objects: a Tracer over all that blocks light, receivers first; paths: a dict that counts them.
    After `solve`: some, seen, missing (K,) bool, of texels that paths lead to, in sight or not, and that miss some.
    """

    def __init__(self, scene, texels, lights, objects, paths):
        self._texels, self._paths = texels, paths
        self._parts = [SubTexels(r, t) for r, t in zip(scene.receivers, texels, strict=True)]
        self._landing = Landing(scene.receivers, texels, self._parts, objects)
        self._cuts = np.cumsum([0, *(len(t.texel) for t in texels)])
        base = self._cuts[:-1, None]
        self._home = np.array([t.home for t in texels]).reshape(len(texels), -1)
        self._home = np.where(self._home >= 0, self._home + base, -1)
        self._area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
        self._lights = [(paths, self._focusing(paths)) for paths in lights]
        self.some, self.seen, self.missing = (np.zeros(len(self._area), bool) for _ in range(3))

    def solve(self, tolerance, seed):
        """Irradiance (K,3) within the relative mean squared error `tolerance`, and the error that it has."""
        strata = np.ones(len(self._area), np.int64)
        halves = np.zeros((2, len(self._area), 3))
        chosen = strata
        for round_ in range(_ROUNDS):
            for half in (0, 1):
                drawn = self._draw(chosen, np.random.default_rng([seed, round_, half]))
                halves[half] = np.where(chosen[:, None] > 0, drawn, halves[half])
            squares = ((halves[0] - halves[1]).mean(1) / 2) ** 2
            power = (self._area @ halves.mean((0, 2))) ** 2 / max(self._area.sum(), np.finfo(float).tiny)
            error = self._area @ squares / power if power > 0 else 0.0
            wanted = self._wanted(strata, squares, tolerance * power)
            chosen = np.where(wanted > strata, wanted, 0)
            if error <= tolerance or not chosen.any() or round_ == _ROUNDS - 1:
                break
            strata = np.maximum(strata, wanted)
        self._paths["sub_points"] = int(2 * (strata**2).sum())
        return halves.mean(0), float(error)

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
        """Irradiance (K,3) of texels with strata (K,) > 0 by strata^2 sub-points in each."""
        flux = np.zeros((len(strata), 3))
        covered = self._area[strata > 0].sum()
        density = (strata**2.0).sum() / max(covered, np.finfo(float).tiny)  # of sub-points
        for paths, sends in self._lights:
            photons = np.ceil(np.sqrt(_PHOTONS * density * paths.lit.area[sends])) ** 2
            each = np.zeros(len(sends))
            each[sends] = photons / paths.lit.area[sends]
            self._throw(paths, np.flatnonzero(sends), photons, each, strata, flux, rng)
            for k, (_, part) in enumerate(self._each()):
                for sub in self._blocks(k, strata[part], len(sends), rng):
                    self._search(paths, sub, each, part, flux)
        return flux / self._area[:, None]

    def _focusing(self, paths):
        """Whether (T,) triangles send photons."""
        ids = paths.triangles
        sends = np.zeros(len(paths.lit.area), bool)
        for own in self._texels if len(ids) else ():
            sends[ids] |= focusing(paths.grid(own.positions), ids, paths.lit.area[ids])
        return sends

    def _blocks(self, k, strata, triangles, rng):
        """The SubPoints of receiver k, in blocks of texels."""
        total = np.cumsum(strata**2)
        cuts = np.arange(max(_POINTS, triangles), total[-1] if len(total) else 0, max(_POINTS, triangles))
        cuts = [0, *np.searchsorted(total, cuts), len(strata)]
        for start, stop in pairwise(cuts):
            block = np.zeros(len(strata), np.int64)
            block[start:stop] = strata[start:stop]
            if block.any():
                yield self._parts[k].draw(block, rng)

    def _search(self, paths, sub, each, part, flux):
        """Add to flux (K,3) what the paths to SubPoints bring, besides `each` (T,) photons an m^2 across the light."""
        found = paths.to(sub.points, sub.normals)
        own = part.start + sub.texel
        texel = own[found.point]
        share = _balanced(sub.area[found.point], found.density, each[found.triangle])
        share *= sub.scale[found.point] * found.visible
        _add(flux, texel, share, paths.arriving(found.passed, found.length))
        self.some[texel] = True
        self.seen[texel[found.visible]] = True
        self.missing[own[found.missing]] = True
        for name, number in (("found", len(texel)), ("blocked", np.count_nonzero(~found.visible))):
            self._paths[name] = self._paths.get(name, 0) + number

    def _throw(self, paths, triangles, photons, each, strata, flux, rng):
        """Add to flux (K,3) what photons (m,) from triangles (m,) bring, `each` (T,) an m^2 across the light."""
        for own, weights, m, direction in throw(paths, triangles, photons, rng):
            self._paths["photons"] = self._paths.get("photons", 0) + len(own)
            at, image, flat, points, normals, area = self._landing.land(m, direction)
            texel = self._home[image, flat]
            kept = np.flatnonzero((texel >= 0) & (strata[texel] > 0))
            at, texel = at[kept], texel[kept]
            own, weights, area = own[at], weights[at], area[kept] / strata[texel] ** 2
            passed, density, length = paths.factors(own, weights, points[kept], normals[kept])
            share = _balanced(area, np.abs(density), each[own]) * ~paths.shadowed(own, weights)
            _add(flux, texel, share, paths.arriving(passed, length))
            self.some[texel] = True
            self.seen[texel[share > 0]] = True


def _balanced(area, density, photons):
    """What a path counts for (n,) [m^2 across the light], by the balance heuristic: found by sub-points that stand for
    `area`, or by `photons` an m^2, where the light falls with `density`."""
    with np.errstate(divide="ignore"):
        return 1 / (1 / (area * density) + photons)


def _add(flux, texel, share, watts):
    """Add share (n,) of watts (n,3) to the flux (K,3) of texels (n,)."""
    for c in range(3):
        flux[:, c] += np.bincount(texel, share * watts[:, c], minlength=len(flux))


def _around(own, values):
    """Mean (K,) of values (K,) over the neighbours of each of the K texels, at most eight; the mean of all where it has
    none."""
    side = own.resolution
    total = np.zeros((2, side + 2, side + 2))
    row, column = np.divmod(own.texel, side)
    total[0, row + 1, column + 1], total[1, row + 1, column + 1] = values, 1
    beside = sum(total[:, 1 + j : side + 1 + j, 1 + i : side + 1 + i] for j in (-1, 0, 1) for i in (-1, 0, 1) if i or j)
    value, count = beside[:, row, column]
    return np.where(count > 0, value / np.maximum(count, 1), values.mean() if len(values) else 0.0)
