"""The conic walk: manifold next-event estimation along the coplanarity curve, one root for the centre of every texel.

After source [1] of `conic.py`. It is exact at a point and knows no noise, but it stops at the first root, so texels
that several paths reach - the bright lines - get less than their light.
"""

from __future__ import annotations

import time

import numpy as np

from ..lit_water import light_water
from ..rays import Tracer, soup
from ..scene import Diagnostics, Sun
from ..solution import answer, check_texels
from ..status import Status
from .conic import Surface
from .path_irradiance import path_irradiance
from .walkers import Walk

_LEFT_OUT = [
    "every path to a texel but the first that the walk meets",
    "the mean over the texel: the value is the one at its centre",
    "the sun's disc: light comes from its centre",
    "light that meets the water twice, is reflected by it or is absorbed in it",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by first roots; see `scene.Solution`.

    It has no tolerance to meet and reads nothing from `settings`. Raises ValueError where texels and receivers do not
    match.
    """
    check_texels(scene, texels)
    work = Diagnostics("conic_walk", "one exact path per texel", left_out=list(_LEFT_OUT))
    start = time.perf_counter()
    points = np.concatenate([np.zeros((0, 3)), *(t.positions for t in texels)])
    normals = np.concatenate([np.zeros((0, 3)), *(t.normals for t in texels)])
    area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
    objects = Tracer(*soup((*scene.receivers, *scene.occluders)))
    water = Tracer(scene.water.positions, scene.water.triangles)
    work.seconds["prepare"] = time.perf_counter() - start
    irradiance, status = np.zeros((len(points), 3)), np.full(len(points), Status.NO_WATER, np.uint8)
    suns = [light for light in scene.lights if isinstance(light, Sun)]
    work.left_out += [
        f"lamp '{light.name}': the walk knows suns only" for light in scene.lights if not isinstance(light, Sun)
    ]
    for sun in suns:
        light, code = _sun(scene, sun, points, normals, water, objects, work)
        irradiance += light[:, None] * sun.irradiance
        status = np.where((code == Status.LIT) | (status == Status.NO_WATER), code, status)
    work.flux_lost["elsewhere"] = work.flux_in - area @ irradiance
    return answer(scene, texels, irradiance, status, work)


def _sun(scene, sun, points, normals, water, objects, work):
    """Irradiance (K,) for 1 W/m^2 of one sun at points (K,3) with normals (K,3), and status (K,)."""
    clock = _Clock(work.seconds)
    lit = light_water(scene.water, sun)
    work.flux_in = work.flux_in + lit.area.sum() * sun.irradiance
    surface = Surface(lit, scene.water.twins)
    clock.lap("prepare")
    p = lit.frame @ points.T
    first = water.first(points, np.broadcast_to(lit.frame[2], points.shape))
    clock.lap("straight rays")
    walk = Walk(surface, p, first, scene.eta).run()
    work.paths["triangle_steps"] = work.paths.get("triangle_steps", 0) + walk.steps
    clock.lap("walk")
    light = np.zeros(len(points))
    found = np.flatnonzero(walk.status == Status.LIT)
    path = walk.triangle[found], walk.weights[found]
    light[found] = path_irradiance(surface, *path, p[:, found], lit.frame @ normals[found].T, scene.eta)
    on_fold = found[~np.isfinite(light[found])]
    light[on_fold], walk.status[on_fold] = 0, Status.LOST
    clock.lap("irradiance")
    hidden = found[_hidden(surface, path, points[found], lit.frame, objects)]
    light[hidden], walk.status[hidden] = 0, Status.BLOCKED
    clock.lap("visibility")
    work.paths["found"] = work.paths.get("found", 0) + len(found)
    work.paths["blocked"] = work.paths.get("blocked", 0) + len(hidden)
    return light, walk.status


def _hidden(surface, path, points, frame, objects):
    """Whether (n,) an object stands between the sun and M, or between M and points (n,3)."""
    m = (frame.T @ surface.at(*path)[0]).T
    blocked = objects.blocked(m, np.broadcast_to(frame[2], m.shape))
    ray = points - m
    length = np.linalg.norm(ray, axis=1)
    return blocked | objects.blocked(m, ray / np.maximum(length, np.finfo(float).tiny)[:, None], length)


class _Clock:
    """Adds the time since the last lap to a stage's seconds."""

    def __init__(self, seconds):
        self._seconds, self._last = seconds, time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self._seconds[stage] = self._seconds.get(stage, 0.0) + now - self._last
        self._last = now
