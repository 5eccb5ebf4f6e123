"""One light on maps whose texels differ in size: the receivers of each size in a pass of its own, see `part.py`.

Every texel may err by as much, those of bright receivers by as much as befits their own light. So each pass keeps to
what the coarsest receivers' mean light allows, or its own, if that is more.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from .kept_light import Followed
from .part import Part
from .sun_disc import added


class Apart(Followed):
    """As `cast.Cast`; one: Part -> its Cast or DiscCast; alike: what `part.sizes` says of Texels."""

    def __init__(self, one, alike, texels):
        self._one, self._alike = one, alike
        self._area, self._count = (np.array([f(own.area) for own in texels]) for f in (np.sum, len))
        self._first = one(Part(alike[0], True))
        self.water, self.strays, self.in_colour = self._first.water, self._first.strays, self._first.in_colour

    @cached_property
    def _whole(self):
        """All receivers in one, for points."""
        return self._one(Part(np.any(self._alike, axis=0)))

    def again(self):
        return 0

    def throw(self, photons, rng):
        """As `Cast.throw`."""
        self._whole.strays = self.strays
        return self._whole.throw(photons, rng)

    def _cast(self, alike, light):
        """What follows light to finer receivers alike (images,) than the coarsest, of which that is the mean."""
        coarse = self._alike[0]
        cast = self._one(Part(alike, False, (self._area / self._count)[coarse].min(), light))
        cast.strays = self.strays
        return cast

    def follow(self):
        """See `Followed`."""
        brought, errors, light = [], 0.0, 0.0
        own = np.repeat(self._alike, self._count, axis=1)
        for alike, texels in zip(self._alike, own, strict=True):
            cast = self._cast(alike, light) if brought else self._first
            flux, lost, met, error, _ = cast.follow()
            mean = flux[:, texels].mean(0).sum() / np.sum(self._area, where=alike)
            light = light or mean
            errors += error * max(mean, light) ** 2 * np.sum(self._count, where=alike)
            brought.append((flux, lost, met))
        flux, lost, met = zip(*brought, strict=True)
        square = (sum(flux).mean(0).sum() / np.sum(self._area)) ** 2 * np.sum(self._count)
        return sum(flux), added(lost), sum(met), errors / square if square else 0.0, self.strays
