"""The plane of an animation's water. Loads no rays: what an animation is made to fit goes between processes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .still import Still

_SOME = 1 << 12  # vertices that heights are taken from, about
_ASIDE = 1 / 16  # texel: how far the outline may be off
_STILL = 1e-6  # texel: what heights are off that are equal


@dataclass(frozen=True)
class Level:
    """The plane of an anchor's water: origin (3,), frame (3,3) and rim (2,2,n), as of `Still`."""

    origin: np.ndarray
    frame: np.ndarray
    rim: np.ndarray

    @classmethod
    def of(cls, water):
        """The Level of a Water; None for water without an open outline."""
        if not len(water.triangles) or not (water.twins < 0).any():
            return None
        still = Still(water, 1.0)
        return cls(still.origin, still.frame, still.rim)

    def holds(self, water, texel):
        """Whether a Water lies about this plane, off it by less in the mean and by slope than by its waves, and ends
        where the anchor's does, as seen by texels that are `texel` [m] wide."""
        here = Still(water, texel, self)
        rim = here.outline()
        if rim.shape != self.rim.shape or not (np.abs(rim - self.rim) <= _ASIDE * texel).all():
            return False
        x, y, z = here.to_plane(water.positions[:: len(water.positions) // _SOME | 1])
        plane = np.stack([np.ones_like(x), x, y])
        off = np.linalg.lstsq(plane @ plane.T, plane @ z, rcond=None)[0] @ plane
        return bool(off @ off <= (z - off) @ (z - off) + len(z) * (_STILL * texel) ** 2)
