"""Still water in closed form: what falls on the receivers if the water were its own mean plane.

One path leads to each point, through the plane and, above it, off it (`paths.py`). What floats or stands in the way
shades by one ray a texel on each leg. The waves themselves are predicted only, as the error of leaving them out
(`ripples.py`).
"""

from __future__ import annotations

import time

import numpy as np

from ..scene import Diagnostics
from ..solution import answer, check_texels
from ..status import Status
from ..surface.deviation import softened
from .anywhere import Anywhere
from .one_floor import OneFloor
from .still import Still

_REASON = "the water's mean plane in closed form, one path per texel"
_LEFT_OUT = [
    "the waves: the light is that of still water, as high as theirs in the mean",
    "light that meets the water twice",
    "penumbrae: shadows are those of the lights' centres, at the centres of texels",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) under still water; see `scene.Solution`.

    Knows no tolerance: its estimated error is what the waves are predicted to add. Raises ValueError where texels and
    receivers do not match.
    """
    check_texels(scene, texels)
    start = time.perf_counter()
    work = Diagnostics("flat", _REASON, left_out=list(_LEFT_OUT))
    irradiance, light, error = combine(lights_of(scene, texels, work, "occlusion" not in settings.without), texels)
    work.estimated_error = softened(scene.water) * error
    work.seconds["closed form"] = time.perf_counter() - start
    return answer(scene, texels, irradiance, np.where(light > 0, Status.LIT, Status.DARK), work)


def lights_of(scene, texels, work, shades=True):
    """For each light of a Scene its irradiance (K,3) on Texels under still water, and its doubt, see `doubt`; books
    what comes in and what is lost in Diagnostics; shades: look for what stands in the way."""
    if not len(scene.water.triangles) or not any(len(t.texel) for t in texels):
        return []
    still = Still(scene.water, np.sqrt(min(t.area.mean() for t in texels if len(t.area))))
    receivers = OneFloor.of(still, scene, texels) or Anywhere.of(still, scene, texels, shades)
    return [receivers.under(light, work) for light in scene.lights]


def combine(parts, texels):
    """Irradiance (K,3) of all `lights_of`, its mean over the channels (K,), and the relative mean squared error that
    the waves are predicted to add."""
    count = sum(len(t.texel) for t in texels)
    irradiance = sum((part for part, _ in parts[1:]), parts[0][0]) if parts else np.zeros((count, 3))
    light = irradiance @ np.full(3, 1 / 3)
    mean = light.sum() / max(count, 1)
    if not mean > 0:
        return irradiance, light, 1.0 if parts else 0.0  # if there is light, all of it is missing
    return irradiance, light, float(sum(off for _, off in parts) / mean**2)
