"""Still water from frame to frame: waves come and go about one plane, and so does its light only where all else stays.

The plane is that of the animation's anchor as long as the water lies about it, no farther off than its own waves are
high. Its light is kept: a frame then takes no more than the error that its waves leave.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ..solution import check_texels
from ..unchanged import unchanged
from .flat import StillLight, estimated, solution, still_of

_KEPT = 3  # lights: those of three channels


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
        light = replace(light, irradiance=np.zeros((0, 3)))  # the images have it
        self._kept = [(key, light, answer), *self._kept[: _KEPT - 1]]
        return light, answer
