"""Light that comes down so densely that sub-points seldom meet it: photons for the triangles that throw it together.

Where the image of a triangle shrinks, to a line on a fold, sub-points meet it ever more rarely and find ever more light
when they do: their mean has no finite variance. Photons from the triangle meet it surely. Both estimates are combined
by the balance heuristic [1]: a path counts with weight 1 / (density of sub-points + density of photons) at its place,
whichever found it, which keeps the mean exact and every contribution below the flux of one photon.

[1] Veach & Guibas 1995, Optimally Combining Sampling Techniques for Monte Carlo Rendering.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from ..splat.lander import texel_maps
from .plan import refract

_DENSE = 2.0  # area across the light per area of the receiver
_BLOCK = 1 << 14  # photons at once
_TRIANGLES = 1 << 12  # at once


class Landing:
    """Where on the receivers rays land: receivers of a Scene, their Texels, objects a Tracer over them, in their order,
    and all that occludes."""

    def __init__(self, receivers, texels, parts, objects):
        self._objects = objects
        self._maps = np.concatenate([np.zeros((0, 3, 4)), *map(texel_maps, receivers, (t.resolution for t in texels))])
        self._normals = np.concatenate([np.zeros((0, 3)), *(p.normals for p in parts)])
        self._density = np.concatenate([np.zeros(0), *(p.density for p in parts)])
        self._image = np.repeat(np.arange(len(receivers)), [len(r.triangles) for r in receivers])
        self._side = texels[0].resolution if texels else 1

    def land(self, m, direction):
        """Rays along direction (3,n) from m (3,n): index of those that land on a front; there, image, flat texel,
        point, normal and [m^2] of a texel."""
        hit = self._objects.first(m.T, direction.T)
        at = np.flatnonzero((hit != MISS) & (hit < len(self._image)))
        triangle, m, direction = hit[at], m[:, at], direction[:, at]
        maps = self._maps[triangle]
        with np.errstate(divide="ignore", invalid="ignore"):
            fall = (maps[:, 0, :3].T * direction).sum(0)
            way = -((maps[:, 0, :3].T * m).sum(0) + maps[:, 0, 3]) / fall
        point = m + way * direction
        sound = np.isfinite(way) & (fall < 0)
        at, triangle, maps, point = at[sound], triangle[sound], maps[sound], point[:, sound]
        top = self._side - 1
        x, y = ((maps[:, k, :3].T * point).sum(0) + maps[:, k, 3] for k in (1, 2))
        i, j = np.clip(x, 0, top).astype(np.int64), np.clip(y, 0, top).astype(np.int64)
        flat = j * self._side + i
        return at, self._image[triangle], flat, point.T, self._normals[triangle], self._density[triangle]


def focusing(grid, triangles, area):
    """Whether (m,) triangles, with area (m,) across the light, throw it together, somewhere in the depths of a
    Grid and beside its points."""
    dense = np.zeros(len(triangles), bool)
    for start in range(0, len(triangles), _TRIANGLES):
        block = slice(start, start + _TRIANGLES)
        lines = grid.lines(*grid.rays.corner[triangles[block]].T, *grid.rays.middle[triangles[block]].T)
        for layer in range(grid.layers):
            images = grid.images(lines, layer)
            near = np.zeros(len(lines[0][0]), bool)
            near[grid.near(images, layer)[0]] = True
            for image in images:
                jacobian = image.jacobian()
                low, high = np.minimum.reduce(jacobian), np.maximum.reduce(jacobian)
                least = np.where(low * high > 0, np.minimum(np.abs(low), np.abs(high)), 0)
                dense[block] |= near & (least * _DENSE < 2 * area[block])
    return dense


def throw(paths, triangles, photons, rng):
    """Yield, in blocks, photons (m,), square numbers, from each of triangles (m,) of LightPaths: triangle (n,), weights
    (n,3), origin and direction (3,n) in the world."""
    strata = np.sqrt(photons).astype(np.int64)
    for m in np.unique(strata):
        group = triangles[strata == m]
        step = max(1, _BLOCK // (m * m))
        for start in range(0, len(group), step):
            own = np.repeat(group[start : start + step], m * m)
            weights = _stratified(m, len(own) // (m * m), rng)
            point, normal = (np.stack(v) for v in paths.surface.at(own, weights))
            facing = np.flatnonzero((paths.surface.arriving(point) * normal).sum(0) < 0)
            own, weights, point = own[facing], weights[facing], point[:, facing]
            direction = refract(normal[:, facing], paths.surface.arriving(point), paths.eta)
            back = paths.lit.frame.T
            yield own, weights, back @ point, back @ direction


def _stratified(m, count, rng):
    """Weights (count * m^2, 3), one in each of m^2 parts of equal area of every one of `count` triangles."""
    square = np.stack(np.divmod(np.arange(m * m), m))[:, None]
    s, t = ((square + rng.random((2, count, m * m))) / m).reshape(2, -1)
    s = np.sqrt(s)
    return np.stack([1 - s, s * (1 - t), s * t], 1)
