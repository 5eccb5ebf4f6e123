"""Light on the texels of several receivers, and by how much one picture of it differs from another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Maps:
    """Irradiance [W/m^2] on the texels of several receivers, one after the other: light (K,3); weight (K,) [m^2], the
    area of each; cuts, where each receiver's texels end but the last's.

    The errors of other light (K,3) against this are over the area of all receivers, or of the one of number `part`, and
    of the texels that are `seen` (K,) bool, if given.
    """

    light: np.ndarray
    weight: np.ndarray
    cuts: tuple

    @classmethod
    def of(cls, texels, light):
        """The Maps of light (K,3) on all Texels."""
        cuts = tuple(int(cut) for cut in np.cumsum([len(t.texel) for t in texels])[:-1])
        return cls(light, np.concatenate([np.zeros(0), *(t.area for t in texels)]), cuts)

    def error(self, light, part=None, seen=None):
        """Mean squared error over the mean square of the light: what Settings.tolerance means."""
        mine, theirs, weight = self._of(light, part, seen)
        return _over((weight * (theirs - mine) ** 2).sum(), (weight * mine**2).sum())

    def error_by_mean(self, light, part=None, seen=None):
        """Mean squared error of the mean of the channels over its squared mean."""
        mine, theirs, weight = self._of(light, part, seen)
        mine, theirs, weight = mine.mean(1), theirs.mean(1), weight[:, 0]
        return _over((weight * (theirs - mine) ** 2).sum() * weight.sum(), (weight * mine).sum() ** 2)

    def mean_error(self, light, part=None, seen=None):
        """Mean absolute error over the mean."""
        mine, theirs, weight = self._of(light, part, seen)
        return _over((weight * np.abs(theirs - mine)).sum(), (weight * mine).sum())

    def energy(self, light, part=None, seen=None):
        """Relative error of the whole flux."""
        mine, theirs, weight = self._of(light, part, seen)
        return _over((weight * (theirs - mine)).sum(), (weight * mine).sum())

    def _of(self, light, part, seen):
        """Light of this and of the other (k,3), and weight (k,1), of what counts."""
        chosen = np.ones(len(self.weight), bool) if seen is None else seen
        if part is not None:
            start, end = (0, *self.cuts)[part], (*self.cuts, len(chosen))[part]
            chosen = chosen & (np.arange(len(chosen)) >= start) & (np.arange(len(chosen)) < end)
        return self.light[chosen], light[chosen], self.weight[chosen, None]


def light_of(texels, images):
    """Light (K,3) [W/m^2] on the texels of all receivers, of their images (R,R,3)."""
    parts = [image.reshape(-1, 3)[own.texel] for own, image in zip(texels, images, strict=True)]
    return np.concatenate([np.zeros((0, 3)), *parts])


def _over(error, whole):
    """`error` over `whole` as a float; where there is no light at all, 0 for no error and inf for any."""
    if whole > 0:
        return float(error / whole)
    return 0.0 if error == 0 else float("inf")
