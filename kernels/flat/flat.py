"""Still water in closed form: what falls on the receivers if the water were its own mean plane.

One path leads to each point, through the plane and, above it, off it (`paths.py`). What floats or stands in the way
shades by one ray a texel on each leg. The waves themselves are predicted only, as the error of leaving them out
(`ripples.py`).
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from ..scene import Diagnostics
from ..solution import answer, check_texels
from ..status import Status
from ..surface.deviation import softened
from .anywhere import Anywhere
from .doubt import Doubt
from .one_floor import OneFloor
from .still import Still

_REASON = "the water's mean plane in closed form, one path per texel"
_LEFT_OUT = [
    "the waves: the light is that of still water, as high as theirs in the mean",
    "light that meets the water twice",
    "penumbrae: shadows are those of the lights' centres, at the centres of texels",
]
_SOME = 1 << 10  # texels that their width is taken from, about


@dataclass(frozen=True)
class StillLight:
    """What falls under a Still plane, whatever the waves about it: irradiance (K,3); work: Diagnostics, of all but the
    waves; doubts: of all lights; light: the mean over texels and channels."""

    irradiance: np.ndarray
    work: Diagnostics
    doubts: tuple[Doubt, ...]
    light: float

    @classmethod
    def of(cls, still, scene, texels, shades=True):
        """That of a Scene on Texels; shades: look for what stands in the way."""
        work = Diagnostics("flat", _REASON, left_out=list(_LEFT_OUT))
        count = sum(len(t.texel) for t in texels)
        if still is None or not count:
            return cls(np.zeros((count, 3)), work, (), 0.0)
        receivers = OneFloor.of(still, scene, texels) or Anywhere.of(still, scene, texels, shades)
        irradiance, doubts = np.zeros((count, 3)), ()
        for light in scene.lights:
            part, own = receivers.under(light, work)
            irradiance, doubts = irradiance + part, (*doubts, *own)
        return cls(irradiance, work, doubts, float(irradiance.mean()))

    def error(self, still):
        """Mean squared error over the squared mean of the light that the water of a Still adds to this plane."""
        if not self.light > 0:
            return 1.0  # if there is light, all of it is missing
        return sum(doubt.of(still) for doubt in self.doubts) / self.light**2


def still_of(scene, texels, level=None):
    """The Still plane of a Scene's water, that of a Level if there is one that holds; None without water or lights."""
    if not len(scene.water.triangles) or not scene.lights or not any(len(t.texel) for t in texels):
        return None
    texel = min(_narrow(own) for own in texels if len(own.texel))
    return Still(scene.water, texel, level if level is not None and level.holds(scene.water, texel) else None)


def _narrow(own):
    """The narrower side [m] of what a texel of Texels stands for, the median of some: UVs may be stretched."""
    some = np.unique(np.linspace(0, len(own.texel) - 1, _SOME).astype(np.int64))
    area, beside = float(np.median(own.area[some])), some[:-1][own.texel[some[:-1] + 1] == own.texel[some[:-1]] + 1]
    if not len(beside):
        return np.sqrt(area)
    wide = float(np.median(np.linalg.norm(own.positions[beside + 1] - own.positions[beside], axis=1)))
    return min(wide, area / wide) if wide > 0 else np.sqrt(area)


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) under still water; see `scene.Solution`.

    Knows no tolerance: its estimated error is what the waves are predicted to add. Raises ValueError where texels and
    receivers do not match.
    """
    check_texels(scene, texels)
    start = time.perf_counter()
    still = still_of(scene, texels)
    light = StillLight.of(still, scene, texels, "occlusion" not in settings.without)
    light.work.estimated_error = estimated(light, still)
    light.work.seconds["closed form"] = time.perf_counter() - start
    return solution(light, scene, texels)


def estimated(light, still):
    """The relative mean squared error that the water of a Still is predicted to add to a StillLight."""
    return softened(still.water) * light.error(still) if still is not None else 0.0


def solution(light, scene, texels):
    """The Solution by a StillLight."""
    status = np.where(light.irradiance.any(1), Status.LIT, Status.DARK)
    return answer(scene, texels, light.irradiance, status, light.work)
