"""Still water from frame to frame: waves come and go about one plane, and so does its light only where all else stays.

The plane is that of the animation's anchor as long as the water lies about it, no farther off than its own waves are
high. Its light is kept: a frame then takes no more than the error that its waves leave.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from ..solution import check_texels
from ..unchanged import unchanged
from .flat import StillLight, estimated, solution, still_of
from .still import Still

_SOME = 1 << 12  # vertices that heights are taken from, about
_ASIDE = 1 / 16  # texel: how far the outline may be off
_STILL = 1e-6  # texel: what heights are off that are equal
_KEPT = 6  # lights: those of three channels, of two kinds of frames


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


class KnownStill:
    """Solves frames of an animation with an anchor of that Level, or None. What it keeps saves time and changes
    nothing."""

    def __init__(self, level=None):
        self._level, self._kept = level, []

    def solve(self, scene, texels, settings):
        """As `flat.solve`."""
        check_texels(scene, texels)
        start = time.perf_counter()
        still = still_of(scene, texels, self._level)
        light, answer = self._light(still, scene, tuple(texels), "occlusion" not in settings.without)
        work = answer.diagnostics
        copies = {name: dict(getattr(work, name)) for name in ("flux_received", "flux_lost", "texels")}
        work = replace(work, left_out=list(work.left_out), **copies)
        work.estimated_error = estimated(light, still)
        work.seconds = {"closed form": time.perf_counter() - start}
        return answer.told(work)

    def _light(self, still, scene, texels, shades):
        """The StillLight and its Solution."""
        plane = (still.origin, still.frame, still.rim, still.texel) if still is not None else ()
        around = scene.receivers, scene.occluders, scene.casters, scene.lights, scene.eta, scene.sigma_a
        key = plane, around, texels, shades
        for known, *found in self._kept:
            if unchanged(known, key):
                return found
        light = StillLight.of(still, scene, texels, shades)
        answer = solution(light, scene, texels)
        for array in (*answer.images, *answer.status):
            array.flags.writeable = False  # other frames share it
        self._kept = [(key, light, answer), *self._kept[: _KEPT - 1]]
        return light, answer
