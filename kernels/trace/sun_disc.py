"""The sun's disc over casters: directions within it, each a sun of its own, as many as the blur is wide. And the size
of a piece of a lamp: places on it, each a lamp.

Glass and mirrors turn the disc about as they turn the light, so that no one ellipse stands for it; its pictures are
added up. Errors of pictures from different directions are independent, which is why each may have more of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..area_lamps import among
from ..disc.disc import rings_within, within_disc
from ..scene import Piece, Sun
from .kept_light import Followed

_MOST = 16  # directions for beams
# On a lamp: places, at most; how wide a blur shows, in texels, and how many places it takes at least for an error of
# _EVEN, which falls with their square: seen at the focus of a ball of glass.
_PLACES, _SHOWS, _FEW, _EVEN = 64, 0.3, 8, 1e-2
_POINTS = 16  # directions that the points of one half come from, together for all pieces of a lamp
# Squared error over the mean square of one direction for a disc a texel wide, and of one in fours, which falls with how
# many they are: up to 0.07 and 0.01 were seen at foci of a ball and of glass.blend; both grow with the disc's area.
_ONE, _FOURS = 2e-2, 8e-3


def directions(scene, light, texels, tolerance):
    """How many directions within a light's disc its beams need over the casters, and how many would be enough.

    The blur is that of light which goes straight on from the casters to the nearest receiver, and through them.
    """
    sized = light.angle > 0 if isinstance(light, Sun) else isinstance(light, Piece) and light.half_axes.any()
    if not sized:
        return 1, 1
    blur = blur_of(scene, light, texels)
    if isinstance(light, Sun):
        most, fours = _MOST, 4 * int(np.ceil(blur**2 * max(1.0, _FOURS / tolerance) / 4))
        enough = fours if _ONE * blur**2 > tolerance else 1
    else:
        most = max(_PLACES // among(light) // 2 * 2, 2)
        pairs = (_FEW + blur**2) * np.sqrt(_EVEN / tolerance) / 2  # every other one makes a picture of its own
        enough = 2 * int(np.ceil(pairs)) if blur > _SHOWS else 1
    return min(enough, most), enough


def blur_of(scene, light, texels):
    """How wide a light's size blurs what goes straight on from casters to the nearest receiver, in texels."""
    texel = np.sqrt(min(t.area.sum() / len(t.area) for t in texels))
    return max(_angle(light, caster) * _way(caster, texels) for caster in scene.casters) / texel


def _angle(light, caster):
    """What angle [rad] a light fills, as a caster sees it: for a Piece, of a square that is as large."""
    if isinstance(light, Sun):
        return light.angle
    sides = 2 * np.linalg.norm(light.half_axes, axis=1)
    away = np.linalg.norm(light.position - caster.positions, axis=1).min()
    return np.sqrt(sides.prod()) / max(away, sides.max() / 2)


def _way(caster, texels):
    """How far [m] light goes from the far side of a caster to the nearest of the receivers, or less."""
    low, high = caster.positions.min(0), caster.positions.max(0)
    middle = (low + high) / 2
    nearest = min((np.linalg.norm(t.positions - middle, axis=1).min(initial=np.inf) for t in texels), default=0.0)
    return nearest + (high - low).max() / 2


class DiscCast(Followed):
    """As `cast.Cast`, of a light with a size, in `count` directions of a Sun's disc or from as many places on a Piece,
    for beams; make: (light, tolerance, number) -> its Cast."""

    def __init__(self, light, count, make, settings):
        self._light, self._count, self._make, self._settings = light, count, make, settings
        whole, self._tolerance = make(light, settings.tolerance), settings.tolerance * among(light)
        self.water, self.strays, self.in_colour = whole.water, whole.strays, whole.in_colour
        self._area, self._part = np.concatenate([t.area for t in whole.texels]), whole.part
        self._own = np.repeat(whole.part.mine, [len(t.area) for t in whole.texels])

    def again(self):
        return 0

    def throw(self, photons, rng):
        """As `Cast.throw`."""
        count = max(_POINTS // among(self._light), 1)
        casts = self._casts(within_disc(self._light, count, rng), self._tolerance)
        flux, lost, met, used = zip(*(cast.throw(photons / count, rng) for cast in casts), strict=True)
        return sum(flux), added(lost), sum(met), sum(used)

    def follow(self):
        """See `Followed`."""
        if isinstance(self._light, Sun):
            parts = rings_within(self._light, self._count)
        else:
            parts = within_disc(self._light, self._count, np.random.default_rng(self._settings.seed))
        flux, halves, lost, met, errors = 0.0, 0.0, [], 0.0, 0.0
        for k, cast in enumerate(self._casts(parts, self._tolerance * self._count)):
            share = (self.water.source.reach / cast.water.source.reach) ** 2 / self._count  # of the power of all
            own, causes, came, error, _ = cast.follow()
            flux, halves = flux + share * own, halves + share * own * (-1) ** k
            lost.append({cause: share * watts for cause, watts in causes.items()})
            met, errors = met + share * came, errors + error / self._count**2
        return flux, added(lost), met, errors + self._between(flux, halves), self.strays

    def _between(self, flux, halves):
        """Mean squared error over the squared mean of what single places of a lamp leave out, from the flux (C,K) of
        all and the difference of every other one's: of two pictures apart by half as many places, each with four times
        the error of all, a half. Of directions within a sun's disc there are too few to tell."""
        if isinstance(self._light, Sun) or not flux.any():
            return 0.0
        light, apart = ((f.mean(0) / self._area)[self._own] for f in (flux, halves))
        return float(np.mean(apart**2) / max(light.mean(), self._part.light) ** 2 / 2)

    def _casts(self, parts, tolerance):
        """Casts of lights `parts` that share it."""
        power = "irradiance" if isinstance(self._light, Sun) else "intensity"
        for k, part in enumerate(parts):
            cast = self._make(replace(part, **{power: np.asarray(getattr(part, power)) / len(parts)}), tolerance, k)
            cast.strays = self.strays
            yield cast


def added(books):
    """The sums of {cause: W} over all books."""
    return {
        cause: sum(book[cause] for book in books if cause in book)
        for cause in dict.fromkeys(k for b in books for k in b)
    }
