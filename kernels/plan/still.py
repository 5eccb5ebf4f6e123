"""Whether the water may be taken as still, and the error of that, without the light itself."""

from __future__ import annotations

import numpy as np

from ..flat.crosses import Crosses
from ..flat.still import Still
from ..scene import Sun
from ..splat.slopes import sheets
from ..surface.deviation import softened

_TEXELS = 1 << 10  # that paths are looked up at, each with its neighbours
_GENTLE = 0.35  # slope of the steepest normal
_SHEET = 1e-3  # of a cell of a grid: what of it may lie under other water
_FAR = 1.0  # of the water's extent: how near a lamp may be
_DEEP = 2.0  # texels: how far below the lowest wave all receivers lie
_ALONG = 0.1  # least cosine between light and what it falls on


def still_error(scene, texels):
    """Mean squared error over the mean square of the light if the water of a Scene lay still, on its Texels, and
    whether anything is shaded there. The error is inf where that method does not hold: for water that is no gentle
    sheet or not shaded smooth, and for what is not all deep under the water and turned towards the light."""
    seen = [t for t in texels if len(t.texel)]
    still = _sheet(scene) if seen else None
    power = [float(np.mean(light.irradiance if isinstance(light, Sun) else light.intensity)) for light in scene.lights]
    if still is None or not sum(power) or not _all_deep(still, scene, seen):
        return np.inf, False
    crosses = Crosses(still, scene, seen, _TEXELS)
    if any(crosses.along(light) > -_ALONG for light in scene.lights):
        return np.inf, False
    error, light, shaded = 0.0, 0.0, False
    for share, source in zip(np.array(power) / sum(power), scene.lights, strict=True):
        e, off, dark = crosses.at(source)
        error, light, shaded = error + share**2 * softened(scene.water) * off, light + share * e, shaded or dark
    return (float(error / (light**2).mean()) if light.any() else np.inf), shaded


def _all_deep(still, scene, texels):
    """Whether all Texels lie below the lowest wave."""
    width = float(np.sqrt(np.concatenate([t.area for t in texels]).mean()))
    lowest = -np.ptp(still.to_plane(scene.water.positions)[2]) - _DEEP * width
    down = still.frame[2]
    return all((t.positions @ down).max() - still.origin @ down <= lowest for t in texels)


def _sheet(scene):
    """The Still plane of a Scene's water, if it is one gentle sheet and all lights are far above it; else None."""
    water = scene.water
    if scene.casters or not len(water.triangles) or not scene.lights:
        return None
    smooth = water.triangles is water.normal_triangles or np.array_equal(water.triangles, water.normal_triangles)
    if not smooth:
        return None
    still = Still(water, 1.0)
    up = water.normals @ still.frame[2]
    if up.min() * up.max() <= 0 or np.abs(up).min() < 1 / np.hypot(1, _GENTLE):
        return None
    plan = (water.positions - still.origin) @ still.frame[:2].T
    v0, v1, v2 = (np.take(plan, water.triangles[:, k], axis=0) for k in range(3))
    across = (v1[:, 0] - v0[:, 0]) * (v2[:, 1] - v0[:, 1]) - (v1[:, 1] - v0[:, 1]) * (v2[:, 0] - v0[:, 0])
    if across.min() * across.max() < 0 or sheets(plan, water.triangles, water.twins) > 1 + _SHEET:
        return None
    extent = np.ptp(plan, axis=0).max()
    for light in scene.lights:
        away = np.inf if isinstance(light, Sun) else still.to_plane(light.position[None])[2, 0]
        facing = -(still.frame[2] @ light.direction) if isinstance(light, Sun) else 1.0
        if away < _FAR * extent or facing <= 0:
            return None
    return still
