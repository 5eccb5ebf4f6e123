"""What a few points find of the light of a cast: where it enters that comes to what counts, from coarse cells to fine.

Small receivers with fine texels get little of the light, and only the cells by which that comes are made as fine as
their texels ask. A cell is cut if points in those about it pass near what counts. What cells that are left out found
lands as it was found: as their own points have no say in it, nothing is lost or counted twice on the whole.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .entry import points
from .follow import Rays
from .picks import ALL, chosen, pick
from .pilot import ALONG

_CELLS = 1 << 16  # are enough


@dataclass
class Found:
    """Rays that a few points sent; what they end on, end (k,); flux (k,) of their points over the power; cell (k,) and
    stratum (2,k) that they entered by; across (k,) [m]: how wide the light of one stratum is there if nothing bends it,
    0 where that is no matter."""

    rays: Rays
    end: np.ndarray
    flux: np.ndarray
    cell: np.ndarray
    stratum: np.ndarray
    across: np.ndarray

    def take(self, at):
        """The Found of a part, see `picks`."""
        if at is ALL:
            return self
        return Found(self.rays.take(at), *(pick(getattr(self, f.name), at) for f in fields(self)[1:]))

    @property
    def share(self):
        """Flux (k,) that comes by these rays."""
        return self.flux * self.rays.share


def search(cast, land):
    """The Found, a list, of the finest cells of a `cast.Cast`, and those of cells that are left out; land(Found, level)
    is called with them."""
    left = []
    for level in range(cast.finer + 1):
        near = np.zeros(len(cast.water.area) // 2, bool)
        found = list(_look(cast, level, near))
        cells = cast.entry.around(near) - near > 0
        if level == cast.finer or 4 * np.count_nonzero(cells) > _CELLS:
            break
        parts = [part.take(np.flatnonzero(~cells[part.cell])) for part in found]
        for part in parts:
            land(part, level)
        left += parts
        cast.divide(cells)
    for part in (*found, *left):
        cast.strays.add(part.rays, part.end, part.share)
    return found, left


def _look(cast, level, near):
    """Yield the Found of a few points in each cell; sets near (n,) bool where they come near what counts."""
    side = np.full(len(near), ALONG)
    for cell, stratum, m, area in points(cast.water, side, cast.entry.place, cast.settings.seed + level):
        rays, met = cast.start(m)
        for ended, end in cast.follower.ends(rays):
            photon = ended.photon
            if level < cast.finer:
                near[cell[photon[cast.passes(ended, end, m[:, photon], ALONG**2 * area[photon])]]] = True
            gone = cast.gone(ended, end) if cast.finer else np.zeros(len(end))
            across = cast.across(m[:, photon], area[photon], gone)
            found = Found(ended, end, np.take(area * met, photon), cell[photon], stratum[:, photon], across)
            yield found.take(chosen(cast.counts(end)))
