"""Still water at some texels and those beside them: what its light is like, and how wrong, at a fixed price."""

from __future__ import annotations

import numpy as np

from ..optics import dot
from .anywhere import Anywhere
from .paths import paths

_GOLDEN = (np.sqrt(5) - 1) / 2  # its multiples follow neither the rows nor the columns of a map
_BESIDE = (0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)  # columns and rows


class Crosses(Anywhere):
    """About `count` of a Scene's Texels with their four neighbours each, all under a Still plane.

    Sums over texels are those over all members of the crosses: five times the centres.
    """

    def __init__(self, still, scene, texels, count):
        parts, before = [], 0
        ends = np.cumsum([len(t.texel) for t in texels])
        picked = (np.arange(min(count, ends[-1])) * _GOLDEN % 1 * ends[-1]).astype(np.int64)
        for own, end in zip(texels, ends, strict=True):
            ids = picked[(picked >= before) & (picked < end)] - before
            parts.append((own, _beside(own, ids)))
            before = end
        positions, normals, area = (
            np.concatenate([getattr(own, name)[ids] for own, ids in parts], 1)
            for name in ("positions", "normals", "area")
        )
        super().__init__(still, scene, positions.reshape(-1, 3), normals.reshape(-1, 3), area.ravel())

    def along(self, light):
        """Greatest cosine between a light's way and the normals of what it falls on: below 0 where it falls on fronts;
        1 for a light below the water."""
        ways = paths(self._still, light, self._p, self._scene.eta, True)
        return 1.0 if ways is None else float(dot(ways.arrives, self._n).max())

    def at(self, light):
        """Irradiance (n,) per unit of the light's power, without absorption; its doubt in the mean over texels; and
        whether anything is shaded."""
        e, books, off = self._by(light, np.arange(len(self._area)), True)
        return e, sum(one.of(self._still) for one in off) / len(e), books["shaded"] > 0

    def _steps(self, _ids, light):
        centre, left, right, down, up = light.reshape(len(_BESIDE), -1)
        sums = np.zeros(2)
        for one, other in ((left, right), (down, up)):
            steps = ((centre - one) ** 2 + (other - centre) ** 2) / 2
            sums += np.nansum(steps), np.nansum((one - 2 * centre + other) ** 2)
        return len(_BESIDE) * sums


def _beside(own, ids):
    """Indices (5,n) of Texels and of those beside them; where one of two has none there, both are the middle one."""
    side = own.resolution
    row, column = np.divmod(own.texel[ids], side)
    beside = [ids]
    for across, up in _BESIDE[1:]:
        x, y = column + across, row + up
        inside = (x >= 0) & (x < side) & (y >= 0) & (y < side)
        flat = np.where(inside, y * side + x, 0)
        at = own.home[flat]
        beside.append(np.where(inside & (at >= 0) & (own.texel[at] == flat), at, -1))
    for k in (1, 3):
        alone = (beside[k] < 0) | (beside[k + 1] < 0)
        for one in (k, k + 1):
            beside[one] = np.where(alone, ids, beside[one])
    return np.stack(beside)
