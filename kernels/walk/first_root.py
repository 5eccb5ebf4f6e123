"""The first root for the centre of every texel, by the walk: the method of source [1] of `conic.py`.

It is exact at a point and knows no noise, but stops at the first root, so texels that several paths reach - the bright
lines - get less than their light, and a point's value is not the mean over its texel.
"""

from __future__ import annotations

import numpy as np

from ..status import Status
from .walkers import Walk

LEFT_OUT = [
    "every path to a texel but the first that the walk meets",
    "the mean over the texel: the value is the one at its centre",
    "the sun's disc: light comes from its centre",
]


def solve(texels, lights, work, clock):
    """Irradiance (K,3) of suns, by their LightPaths `lights`, at the centres of Texels, and status (K,)."""
    points = np.concatenate([np.zeros((0, 3)), *(t.positions for t in texels)])
    normals = np.concatenate([np.zeros((0, 3)), *(t.normals for t in texels)])
    irradiance, status = np.zeros((len(points), 3)), np.full(len(points), Status.NO_WATER, np.uint8)
    for paths in lights:
        watts, code = _roots(paths, points, normals, work, clock)
        irradiance += watts
        status = np.where((code == Status.LIT) | (status == Status.NO_WATER), code, status)
    return irradiance, status


def _roots(paths, points, normals, work, clock):
    """Irradiance (K,3) of a sun by its LightPaths at points (K,3) with normals (K,3), and status (K,)."""
    first = paths.first_water(points)
    clock.lap("straight rays")
    walk = Walk(paths.surface, paths.lit.frame @ points.T, first, paths.eta).run()
    work.paths["triangle_steps"] = work.paths.get("triangle_steps", 0) + walk.steps
    clock.lap("walk")
    found = np.flatnonzero(walk.status == Status.LIT)
    path = walk.triangle[found], walk.weights[found]
    watts = np.zeros((len(points), 3))
    watts[found] = paths.irradiance(*paths.factors(*path, points[found], normals[found]))
    on_fold = np.flatnonzero(~np.isfinite(watts).all(1))
    watts[on_fold], walk.status[on_fold] = 0, Status.LOST
    clock.lap("irradiance")
    hidden = found[paths.hidden(*path, points[found], normals[found])]
    watts[hidden], walk.status[hidden] = 0, Status.BLOCKED
    clock.lap("visibility")
    work.paths["found"] = work.paths.get("found", 0) + len(found)
    work.paths["blocked"] = work.paths.get("blocked", 0) + len(hidden)
    return watts, walk.status
