"""The ellipse that a lamp's disc becomes on each texel, by its second moments.

A turn of the light by delta moves the point where a refracted ray lands by Q delta to first order, Q = tau B J: J how
the refracted ray turns, tau how far it goes, B the receiver's map to texels. Of a disc of half angle R the ellipse has
the second moments R^2 Q Q^T / 4. J is that of light on the water's mean plane, for texels below it refracted, for those
above it reflected.
"""

from __future__ import annotations

import numpy as np

from ..optics import cosine_refracted
from ..splat.lander import texel_maps


def ellipses(lit, receivers, texels, eta, radius):
    """Second moments xx, yy, xy (3,K) [texel^2] at the Texels of each receiver, of the disc of half angle `radius`
    [rad] of the light on a LitWater."""
    n, middle, slope = mean_plane(lit)
    ways = [(t, radius * dt, slope * bend) for t, dt, bend in (_refracted(lit.frame, n, eta), _reflected(lit.frame, n))]
    return [_under_plane(r, t, n, middle, ways) for r, t in zip(receivers, texels, strict=True)]


def mean_plane(lit):
    """Unit normal (3,) of the lit water on average, towards the light, a point (3,) of it, and how far normals lean in
    one direction, root mean square."""
    share = np.repeat(lit.area / (3 * lit.area.sum()), 3)
    of_position = np.bincount(lit.triangles.ravel(), share, len(lit.positions))
    of_normal = np.bincount(lit.normal_triangles.ravel(), share, len(lit.normals))
    n = of_normal @ lit.normals
    n /= np.linalg.norm(n)
    along = lit.normals @ n
    lean = of_normal @ (np.einsum("vk,vk->v", lit.normals, lit.normals) - along**2) / 2
    return lit.frame.T @ n, lit.frame.T @ (of_position @ lit.positions), np.sqrt(max(lean, 0.0))


def _under_plane(receiver, texels, n, middle, ways):
    """As `ellipses`, of one receiver, under a plane through `middle` (3,) of normal n (3,); ways: what `_at_unit_depth`
    takes, for texels below the plane and above it."""
    rise = texels.positions @ n - middle @ n
    maps = texel_maps(receiver, texels.resolution)
    moments = np.zeros((3, len(rise)))
    for own, way in zip((rise <= 0, rise > 0), ways, strict=True):
        if own.any():
            take = slice(None) if own.all() else own
            depth = np.maximum(rise[take] / (way[0] @ n), 0)
            moments[:, take] = np.take(_at_unit_depth(maps, *way), texels.triangle[take], axis=1) * depth**2
    return moments


def _refracted(frame, n, eta):
    """Direction t (3,) of light that is refracted at normal n, how it turns with the light, dt (3,2), and with n."""
    s, across = frame[2], frame[:2].T
    c = s @ n
    c_t = cosine_refracted(c, eta)
    turn = -(n @ across)  # of c
    gamma = c / eta - c_t
    return gamma * n - s / eta, across / eta + np.outer(n, (1 / eta - c / (c_t * eta * eta)) * turn), abs(gamma)


def _reflected(frame, n):
    """As `_refracted`, of light that is reflected."""
    s, across = frame[2], frame[:2].T
    return 2 * (s @ n) * n - s, across - 2 * np.outer(n, n @ across), 2 * (s @ n)


def _at_unit_depth(maps, t, dt, wander):
    """Second moments xx, yy, xy (3,T) [texel^2/m^2], at unit depth, of light t that turns by dt (3,2) over an even
    disc, on the surfaces of texel maps (T,3,4).

    wander: how far waves turn the light to one side, root mean square: no more along a surface than that is it ever.
    """
    fall = maps[:, 0, :3] @ t
    fall = np.where(fall < 0, -1.0, 1.0) * np.sqrt(fall**2 + wander**2 + np.finfo(float).eps)
    slide = dt - t[:, None] * ((maps[:, 0, :3] @ dt) / fall[:, None])[:, None]
    q = maps[:, 1:, :3] @ slide
    return np.stack([(q[:, a] * q[:, b]).sum(1) for a, b in ((0, 0), (1, 1), (0, 1))]) / 4
