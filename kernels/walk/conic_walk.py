"""The conic walk: manifold next-event estimation from the texels, by every path that leads to each.

The paths come from the images of the water's triangles (`candidates.py`), each solved for exactly (`all_roots.py`), and
are proven to be all (`certificate.py`). What is stored is the mean over the texel, of points in it (`texel_means.py`)
and, where the water throws its light together, of beams (`concentrated.py`).
With Settings.first_root the walk of the method's source finds one path to each texel's centre instead
(`first_root.py`).
"""

from __future__ import annotations

import time

import numpy as np

from ..area_lamps import lamp_of
from ..disc.disc import Disc
from ..rays import solid
from ..scene import Diagnostics, Sun
from ..solution import answer, check_texels
from ..status import Status
from . import first_root
from .concentrated import LEFT_OUT
from .paths import LightPaths
from .texel_means import Means

_REASONS = {
    False: "every exact path to points of each texel, and beams where light is thrown together",
    True: "one exact path per texel",
}
_LEFT_OUT = [
    "light that meets the water twice or is reflected by it",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by paths from the texels; see `scene.Solution`.

    Settings.tolerance is the relative mean squared error that is good enough, against the same mesh;
    Settings.first_root asks for the first path to each texel's centre only, and knows no tolerance. Raises
    ValueError where texels and receivers do not match.
    """
    check_texels(scene, texels)
    own = first_root.LEFT_OUT if settings.first_root else LEFT_OUT
    work = Diagnostics("conic_walk", _REASONS[settings.first_root], left_out=[*own, *_LEFT_OUT])
    known = [light for light in scene.lights if isinstance(light, Sun) or not settings.first_root]
    others = [light for light in scene.lights if settings.first_root and not isinstance(light, Sun)]
    work.left_out += dict.fromkeys(f"lamp '{lamp_of(light)}': the walk knows suns only" for light in others)
    clock = _Clock(work.seconds)
    *solids, objects = solid((*scene.receivers, *scene.occluders, *scene.casters))
    lights = [LightPaths(scene, light, objects, solids, settings.without) for light in known]
    work.flux_in = sum((paths.lit.light() * paths.lit.source.power for paths in lights), np.zeros(3))
    clock.lap("prepare")
    if settings.first_root:
        irradiance, status = first_root.solve(texels, lights, work, clock)
    else:
        irradiance, status = _means(scene, texels, list(zip(known, lights)), objects, settings, work)
        clock.lap("paths")
    area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
    work.flux_lost["elsewhere"] = work.flux_in - area @ irradiance
    return answer(scene, texels, irradiance, status, work)


def _means(scene, texels, lights, objects, settings, work):
    """Irradiance (K,3) in the mean over all texels, and status (K,), of pairs of lights and their LightPaths."""
    count = sum(len(t.texel) for t in texels)
    irradiance, errors = np.zeros((count, 3)), [0.0]
    some, seen, missing = np.zeros((3, count), bool)
    for disc, group in _by_disc(scene, texels, lights, settings.tolerance):
        means = Means(scene, texels, group, objects, work.paths)
        light, error = means.solve(disc.left if disc else settings.tolerance, settings.seed)
        if disc:
            light = disc.blur_light(light)
            error += disc.doubt(light.mean(1))
            seen |= light.any(1)
        irradiance += light
        errors.append(error)
        some, seen, missing = some | means.some, seen | means.seen, missing | means.missing
    work.estimated_error = max(errors)
    status = np.where(seen, Status.LIT, np.where(some, Status.BLOCKED, Status.NO_WATER)).astype(np.uint8)
    dark = np.flatnonzero(~(some | seen))
    positions = np.concatenate([np.zeros((0, 3)), *(t.positions for t in texels)])[dark]
    for _, paths in lights if len(dark) else ():
        status[dark[paths.first_water(positions) >= 0]] = Status.DARK
    status[missing] = Status.INCOMPLETE
    return irradiance, status


def _by_disc(scene, texels, lights, tolerance):
    """Pairs of a Disc and the LightPaths of its sun, and one of None and those of all lights without a disc that is
    seen."""
    plain = []
    for light, paths in lights:
        disc = Disc(paths.lit, scene.receivers, texels, scene.eta, light, tolerance, finest=1)
        if disc.seen:
            yield disc, [paths]
        else:
            plain.append(paths)
    if plain or not lights:
        yield None, plain


class _Clock:
    """Adds the time since the last lap to a stage's seconds."""

    def __init__(self, seconds):
        self._seconds, self._last = seconds, time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self._seconds[stage] = self._seconds.get(stage, 0.0) + now - self._last
        self._last = now
