"""Whether the water may be taken as still, and the error of that, without the light itself."""

from __future__ import annotations

import numpy as np

from ..flat.paths import paths
from ..flat.ripples import Ripples
from ..flat.still import Still
from ..optics import dot
from ..rays import Tracer, soup
from ..scene import Sun
from ..splat.slopes import sheets
from ..surface.deviation import softened

_TEXELS = 1 << 10  # that paths are looked up at, about
_GENTLE = 0.35  # slope of the steepest normal
_SHEET = 1e-3  # of a cell of a grid: what of it may lie under other water
_FAR = 1.0  # of the water's extent: how near a lamp may be
_COVERED = 0.9  # of the cell round where light enters: the rim is farther off than a cell
_DEEP = 2.0  # texels: how far below the lowest wave all receivers lie
_ALONG = 0.1  # least cosine between light and what it falls on
_BOX = np.sqrt(3)  # side of the square with the variance of a disc of radius 1


def still_error(scene, texels):
    """Mean squared error over the squared mean of the light if the water of a Scene lay still, on its Texels; inf where
    that method does not hold: for water that is no gentle sheet or not shaded smooth, for things in the way, and for
    what is not all deep under the water, turned towards the light, and lit."""
    seen = [t for t in texels if len(t.texel)]
    still = _sheet(scene) if seen else None
    if still is None or scene.occluders:
        return np.inf
    step = sum(len(t.texel) for t in seen) // _TEXELS | 1
    points, normals = (np.concatenate([v[::step] for v in of]) for of in zip(*((t.positions, t.normals) for t in seen)))
    width = float(np.sqrt(np.concatenate([t.area for t in seen]).mean()))
    lowest = -np.ptp(still.to_plane(scene.water.positions)[2]) - _DEEP * width
    tracer = Tracer(*soup(scene.receivers))
    power = [float(np.mean(light.irradiance if isinstance(light, Sun) else light.intensity)) for light in scene.lights]
    if (still.to_plane(np.concatenate([t.positions for t in seen]))[2] > lowest).any() or not sum(power):
        return np.inf
    p, n = still.to_plane(points), still.frame @ normals.T
    errors = [_under(still, tracer, light, p, n, scene.eta, width) for light in scene.lights]
    error = sum((share / sum(power)) ** 2 * error for share, error in zip(power, errors, strict=True))
    return float(softened(scene.water) * error)


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


def _under(still, tracer, light, p, n, eta, texel):
    """The error under one light at points p (3,n) in the plane with normals n (3,n) there; inf where any of them is not
    lit, or light falls along it."""
    ways = paths(still, light, p, eta, True)
    if ways is None:
        return np.inf
    along = np.broadcast_to(ways.arrives, p.shape)
    if (dot(along, n) > -_ALONG).any() or (still.covered(*ways.enters) < _COVERED).any():
        return np.inf
    enters = still.to_world(np.concatenate([ways.enters, np.zeros((1, p.shape[1]))]))
    if tracer.blocked(enters, along.T @ still.frame, ways.length).any():
        return np.inf
    radius = light.angle / 2 if isinstance(light, Sun) else light.radius / max(float(np.mean(ways.away)), light.radius)
    penumbra = 2 * radius * float(ways.length.mean()) / eta
    squared, _ = Ripples(still, ways, eta, True, np.hypot(texel, _BOX / 2 * penumbra)).squared(ways)
    weight = ways.strength**2
    return float((squared * weight).mean() / ways.strength.mean() ** 2)
