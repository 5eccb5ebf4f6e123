"""The sun's disc over casters: directions within it, each a sun of its own, as many as the blur is wide.

Glass and mirrors turn the disc about as they turn the light, so that no one ellipse stands for it; its pictures are
added up. Errors of pictures from different directions are independent, which is why each may have more of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..disc.disc import within_disc
from ..scene import Sun
from .kept_light import Followed

_MOST = 16  # directions for beams
_POINTS = 16  # directions that the points of one half come from
_SEEN = 1.0  # texels: so far apart may directions land


def directions(scene, light, texels):
    """How many directions within a light's disc its beams need over the casters, and how many would be enough.

    The blur is that of light which goes straight on from the casters to the nearest receiver, and through them.
    """
    if not isinstance(light, Sun) or light.angle <= 0:
        return 1, 1
    texel = np.sqrt(min(t.area.sum() / len(t.area) for t in texels))
    blur = light.angle * max(_way(caster, texels) for caster in scene.casters) / texel
    enough = int(np.ceil((blur / _SEEN) ** 2)) if blur > _SEEN else 1
    return min(enough, _MOST), enough


def _way(caster, texels):
    """How far [m] light goes from the far side of a caster to the nearest of the receivers, or less."""
    low, high = caster.positions.min(0), caster.positions.max(0)
    middle = (low + high) / 2
    nearest = min((np.linalg.norm(t.positions - middle, axis=1).min(initial=np.inf) for t in texels), default=0.0)
    return nearest + (high - low).max() / 2


class DiscCast(Followed):
    """As `cast.Cast`, of a Sun with a disc in `count` directions for beams; make: (Sun, tolerance) -> its Cast."""

    def __init__(self, light, count, make, settings):
        self._light, self._count, self._make, self._settings = light, count, make, settings
        whole = make(light, settings.tolerance)
        self.water, self.strays, self.in_colour = whole.water, whole.strays, whole.in_colour

    def again(self):
        return 0

    def throw(self, photons, rng):
        """As `Cast.throw`."""
        casts = self._casts(_POINTS, rng, self._settings.tolerance)
        flux, lost, met, used = zip(*(cast.throw(photons / _POINTS, rng) for cast in casts), strict=True)
        return sum(flux), _added(lost), sum(met), sum(used)

    def follow(self):
        """See `Followed`."""
        rng = np.random.default_rng(self._settings.seed)
        casts = self._casts(self._count, rng, self._settings.tolerance * self._count)
        flux, lost, met, error, _ = zip(*(cast.follow() for cast in casts), strict=True)
        lost = {cause: watts / self._count for cause, watts in _added(lost).items()}
        return sum(flux) / self._count, lost, sum(met) / self._count, sum(error) / self._count**2, self.strays

    def _casts(self, count, rng, tolerance):
        """Casts of `count` suns that share the light."""
        for sun in within_disc(self._light, count, rng):
            cast = self._make(replace(sun, irradiance=np.asarray(sun.irradiance) / count), tolerance)
            cast.strays = self.strays
            yield cast


def _added(books):
    """The sums of {cause: W} over all books."""
    return {
        cause: sum(book[cause] for book in books if cause in book)
        for cause in dict.fromkeys(k for b in books for k in b)
    }
