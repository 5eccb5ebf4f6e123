"""The conic walk: manifold next-event estimation from the texels, by every path that leads to each.

The paths come from the images of the water's triangles (`candidates.py`), each solved for exactly (`all_roots.py`), and
are proven to be all (`certificate.py`). With Settings.first_root the walk of the method's source finds one path per
texel instead (`first_root.py`).
"""

from __future__ import annotations

import time

import numpy as np

from ..rays import Tracer, soup
from ..scene import Diagnostics, Sun
from ..solution import answer, check_texels
from ..status import Status
from . import first_root
from .paths import LightPaths

_REASONS = {False: "every exact path to each texel", True: "one exact path per texel"}
_LEFT_OUT = [
    "the mean over the texel: the value is the one at its centre",
]
_LEFT_OUT_OF_BOTH = [
    "the sun's disc: light comes from its centre",
    "light that meets the water twice or is reflected by it",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by paths from the texels; see `scene.Solution`.

    Settings.first_root asks for the first path to each texel's centre only. Raises ValueError where texels and
    receivers do not match.
    """
    check_texels(scene, texels)
    own = first_root.LEFT_OUT if settings.first_root else _LEFT_OUT
    work = Diagnostics("conic_walk", _REASONS[settings.first_root], left_out=[*own, *_LEFT_OUT_OF_BOTH])
    work.left_out += [
        f"lamp '{light.name}': the walk knows suns only" for light in scene.lights if not isinstance(light, Sun)
    ]
    clock = _Clock(work.seconds)
    points = np.concatenate([np.zeros((0, 3)), *(t.positions for t in texels)])
    normals = np.concatenate([np.zeros((0, 3)), *(t.normals for t in texels)])
    area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
    objects = Tracer(*soup((*scene.receivers, *scene.occluders)))
    irradiance, status = np.zeros((len(points), 3)), np.full(len(points), Status.NO_WATER, np.uint8)
    incomplete = np.zeros(len(points), bool)
    for light in scene.lights:
        if not isinstance(light, Sun):
            continue
        paths = LightPaths(scene, light, objects)
        work.flux_in = work.flux_in + paths.lit.area.sum() * light.irradiance
        clock.lap("prepare")
        if settings.first_root:
            watts, code = first_root.first_roots(paths, light, points, normals, work, clock)
        else:
            watts, code = _all_roots(paths, light, texels, work)
            clock.lap("paths")
        irradiance += watts
        incomplete |= code == Status.INCOMPLETE
        status = np.where((code == Status.LIT) | (status == Status.NO_WATER), code, status)
    status[incomplete] = Status.INCOMPLETE
    work.flux_lost["elsewhere"] = work.flux_in - area @ irradiance
    return answer(scene, texels, irradiance, status, work)


def _all_roots(paths, light, texels, work):
    """Irradiance (K,3) of a light by its LightPaths at the centres of all texels, and status (K,)."""
    watts, status = [], []
    for own in texels:
        found = paths.to(own.positions, own.normals)
        count = len(own.texel)
        E = paths.irradiance(light, found.passed, found.density, found.length) * found.visible[:, None]
        watts.append(np.stack([np.bincount(found.point, c, minlength=count) for c in E.T], 1))
        some, seen = (np.bincount(found.point, v, minlength=count) > 0 for v in (None, found.visible))
        code = np.where(seen, Status.LIT, np.where(some, Status.BLOCKED, Status.NO_WATER)).astype(np.uint8)
        dark = np.flatnonzero(~some)
        code[dark[paths.first_water(own.positions[dark]) >= 0]] = Status.DARK
        code[~np.isfinite(watts[-1]).all(1)] = Status.LOST
        code[found.missing] = Status.INCOMPLETE
        watts[-1][code == Status.LOST] = 0
        status.append(code)
        for name, number in (("found", len(found.point)), ("blocked", np.count_nonzero(~found.visible))):
            work.paths[name] = work.paths.get(name, 0) + number
    return np.concatenate([np.zeros((0, 3)), *watts]), np.concatenate([np.zeros(0, np.uint8), *status])


class _Clock:
    """Adds the time since the last lap to a stage's seconds."""

    def __init__(self, seconds):
        self._seconds, self._last = seconds, time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self._seconds[stage] = self._seconds.get(stage, 0.0) + now - self._last
        self._last = now
