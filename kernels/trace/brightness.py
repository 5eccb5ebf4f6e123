"""How bright texels are, roughly, by the light of a few points: where it is dark, small errors show."""

from __future__ import annotations

import numpy as np

_BLOCK = 8  # texels along the side of what has one brightness
_DARK = 0.1  # of the mean: what is darker than that is alike


class Brightness:
    """Of the images of Texels, all of one resolution; 1 is the mean of what is lit; mine (images,) bool: those that
    light may fall on, all if it is None."""

    def __init__(self, texels, mine=None):
        self._side = -(-texels[0].resolution // _BLOCK) if texels else 1
        self._flux = np.zeros(len(texels) * self._side**2)
        self._lit = np.ones(len(texels), bool) if mine is None else mine
        self._area = np.array([_BLOCK**2 * t.area.sum() / len(t.area) for t in texels])

    def add(self, image, x, y, flux):
        """Add points at x, y (k,) [texel] of images (k,) with flux (k,)."""
        self._flux += np.bincount(self._cell(image, x, y), flux, len(self._flux))

    def at(self, image, x, y):
        """By how much more (k,) squared error may be left at x, y (k,) of images (k,) than where it is as bright as in
        the mean. The root of the brightness lies between an error that is alike everywhere, which shows as speckles
        where it is dark, and one that is alike over what is there, for which many rays are spent on little light."""
        mean = self._flux.sum() / (np.repeat(self._area[self._lit], self._side**2)).sum()
        light = np.take(self._flux, self._cell(image, x, y)) / np.take(self._area, image)
        return np.sqrt(light / max(mean, np.finfo(float).tiny) + _DARK)

    def _cell(self, image, x, y):
        i, j = (np.clip(v / _BLOCK, 0, self._side - 1).astype(np.int64) for v in (x, y))
        return (image * self._side + j) * self._side + i
