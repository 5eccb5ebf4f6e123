"""The sun map [1]: look straight up from each texel, and take from an image of the sun what the water's slope shows.

The ray up meets the water at some distance and gradient; along (gradient, 1), over that distance, it is off by so much,
and the image of the sun, bright in its middle and dark outside, is looked up there. Deep water shows less of the sun
and sharper lines; still water shows the image's middle. That the sun is overhead is part of the method: a sun that is
not moves neither the image nor the rays. It is a look, not the light: on the pool it correlates with that by 0.1 to 0.4
under a sun overhead, and not at all under others.

The source's lengths are kept, in metres: 0.8 of the distance is looked up, in an image that ends 0.5 from its middle.
It leaves the image's profile free, here 1 - r^2, and the brightness, here such that all the light of still water
(`flat`) is there, no more and no less.

[1] Guardado & Sánchez-Crespo 2004, Rendering Water Caustics, GPU Gems, chapter 2: 2.5, listings 2-1 and 2-2.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from ..flat.flat import StillLight, still_of
from ..rays import MISS, Tracer
from ..solution import answer, check_texels
from ..status import Status

_SCALE, _HALF_WIDTH = 0.8, 0.5  # of the look-up; of the image [m]
_STEEPEST = 1e-3  # cosine between a normal and the vertical, at least
_REASON = "a look: one vertical ray and one look-up in an image of the sun per texel"
_LEFT_OUT = [
    "the paths of light: this is a look of caustics, not the light, whose lines are elsewhere",
    "where the sun stands, but for shadows and the light of still water: the pattern is that of a sun overhead",
    "light that meets the water twice",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver), as it might look; see `scene.Solution`.

    Its estimated error is what the waves would add to still water, and what the pattern adds, as if these knew nothing
    of each other. Raises ValueError where texels and receivers do not match.
    """
    check_texels(scene, texels)
    start = time.perf_counter()
    still = still_of(scene, texels)
    under = StillLight.of(still, scene, texels)
    work = replace(under.work, method="sun_map", reason=_REASON, left_out=list(_LEFT_OUT))
    irradiance, error = under.irradiance, under.error(still) if still is not None else 0.0
    light = irradiance @ np.full(3, 1 / 3)
    work.seconds["still water"] = time.perf_counter() - start
    start = time.perf_counter()
    if light.any():
        area = np.concatenate([t.area for t in texels])
        pattern = _seen(scene.water, np.concatenate([t.positions for t in texels]))
        pattern /= (area * light) @ pattern / (area @ light) or 1.0
        irradiance = irradiance * pattern[:, None]
        error += float((light * (pattern - 1)) @ (light * (pattern - 1)) / len(light) / light.mean() ** 2)
    work.estimated_error = error
    work.seconds["look up"] = time.perf_counter() - start
    status = np.where(irradiance.any(1), Status.LIT, Status.DARK) if len(irradiance) else np.zeros(0, np.uint8)
    return answer(scene, texels, irradiance, status, work)


def _seen(water, points):
    """What points (n,3) see of the sun (n,), 1 for all of it; where no water is above, the mean of the others."""
    up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    triangle = Tracer(water.positions, water.triangles).first(points, up)
    hit = np.flatnonzero(triangle != MISS)
    depth, gradient = _above(water, points[hit], triangle[hit])
    off = _SCALE * depth * np.sqrt((gradient * gradient).sum(0)) / _HALF_WIDTH
    seen = np.full(len(points), np.nan)
    seen[hit] = np.maximum(1 - off * off, 0.0)
    return np.where(np.isnan(seen), seen[hit].mean() if len(hit) else 1.0, seen)


def _above(water, points, triangle):
    """Height (n,) of triangles (n,) over points (n,3), and the gradient (2,n) of their normals there."""
    a, b, c = (water.positions[water.triangles[triangle, k]].T for k in range(3))
    p = points.T
    e1, e2, q = b - a, c - a, p - a
    across = e1[0] * e2[1] - e1[1] * e2[0]
    across = np.where(across == 0, np.inf, across)
    second, third = (q[0] * e2[1] - q[1] * e2[0]) / across, (e1[0] * q[1] - e1[1] * q[0]) / across
    height = a[2] + second * e1[2] + third * e2[2] - p[2]
    weights = np.stack([1 - second - third, second, third], 1)
    normal = (water.normals[water.normal_triangles[triangle]] * weights[:, :, None]).sum(1).T
    length = np.sqrt((normal * normal).sum(0))
    upright = np.maximum(np.abs(normal[2]), _STEEPEST * length)
    return np.maximum(height, 0.0), normal[:2] / np.maximum(upright, np.finfo(float).tiny)
