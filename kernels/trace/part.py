"""What one pass over casters lights: receivers whose texels are about as large.

One pass for all would go with the finest texels there are: a coin on a table has cells, directions of a sun's disc and
beams made for the coin alone wherever light goes. So there is a pass for each size of texels. Each follows all light
until it is known to go elsewhere, and counts what ends on its own receivers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..optics import dot

_ALIKE = 2.0  # texels' sides that differ by less are of one size
_AROUND = 2.0  # cells: light that goes by a receiver as near as that may meet it


@dataclass(frozen=True)
class Part:
    """mine (images,) bool: receivers whose light counts; rest: whether light that ends on no receiver does; coarsest:
    area [m^2] of the texels that the search for light starts with, 0 where there is none; light: irradiance over the
    power that errors are measured by, at least."""

    mine: np.ndarray
    rest: bool = True
    coarsest: float = 0.0
    light: float = 0.0

    def of(self, things):
        """Those of things, one for each receiver, that are of its own."""
        return [thing for thing, own in zip(things, self.mine, strict=True) if own]

    @property
    def whole(self):
        """Whether it is all there is."""
        return self.rest and self.mine.all()


def sizes(texels):
    """Which (images,) bool have texels of one size, for each size of Texels, the coarsest first."""
    side = np.sqrt([own.area.sum() / max(len(own.area), 1) for own in texels])
    left, found = np.ones(len(texels), bool), []
    while left.any():
        own = left & (side * _ALIKE > side[left].max())
        found.append(own if own.any() else left.copy())
        left &= ~found[-1]
    return found or [left]


class Near:
    """Whether light goes near receivers: spheres round each."""

    def __init__(self, receivers):
        low, high = (np.array([f(r.positions, axis=0) for r in receivers]).reshape(-1, 3) for f in (np.min, np.max))
        self._centre, self._radius = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2

    def passed(self, rays, distance, width):
        """Whether (k,) Rays that go on for `distance` (k,) [m] pass a receiver by less than _AROUND times width(way),
        (k,) [m] after ways (k,)."""
        near = np.zeros(len(distance), bool)
        for centre, radius in zip(self._centre, self._radius, strict=True):
            apart = centre[:, None] - rays.origin
            along = np.clip(dot(apart, rays.direction), 0, distance)
            apart -= along * rays.direction
            near |= np.sqrt(dot(apart, apart)) <= radius + _AROUND * width(rays.way + along)
        return near
