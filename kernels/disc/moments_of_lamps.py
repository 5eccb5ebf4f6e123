"""The ellipse that the size of a lamp becomes on each texel, by its second moments.

A lamp that moves by delta turns its light at a fixed point of the water, R away, by -(1 - d d^T) delta / R, and what is
bent there lands Q delta away, as the light of a sun does that turns (`moments.py`). Each texel has a place of its own
on the water's mean plane that its light comes from, with its own d and R.
"""

from __future__ import annotations

import numpy as np

from ..flat.paths import entry
from ..optics import cosine_refracted, dot
from ..splat.lander import texel_maps

_BLOCK = 1 << 14  # texels at once: what is known of them stays in the cache
_TINY = np.finfo(float).tiny


def ellipses_of_lamp(plane, position, extent, receivers, texels, eta):
    """Second moments xx, yy, xy (3,K) [texel^2] at the Texels of each receiver, of a lamp at position (3,) with
    extent (m,3) [m]: rows whose outer products sum to its second moments.

    plane: unit normal (3,) towards the lamp and a point (3,) of the water on average, and how far normals lean.
    """
    lamp = _Lamp(*plane, position, extent, eta)
    return [_on_receiver(lamp, r, t) for r, t in zip(receivers, texels, strict=True)]


def _on_receiver(lamp, receiver, texels):
    maps = texel_maps(receiver, texels.resolution)
    moments = np.zeros((3, len(texels.positions)))
    rise = lamp.rise(texels.positions)
    for below in (True, False):
        ids = np.flatnonzero((rise < 0) == below) if lamp.height > 0 else np.zeros(0, np.int64)
        for start in range(0, len(ids), _BLOCK):
            some = ids[start : start + _BLOCK]
            own = maps[texels.triangle[some]].transpose(1, 2, 0)
            moments[:, some] = lamp.seen(texels.positions[some].T, np.abs(rise[some]), own, below)
    return moments


class _Lamp:
    """A lamp of some extent over the mean plane of the water."""

    def __init__(self, n, middle, slope, position, extent, eta):
        self._n, self._middle, self._slope, self._eta = n, middle, slope, eta
        self._position, self._extent = position, extent
        self.height = float(n @ (position - middle))

    def rise(self, points):
        """Heights (k,) of points (k,3) over the plane."""
        return points @ self._n - self._middle @ self._n

    def seen(self, p, deep, maps, below):
        """Second moments (3,k) at points p (3,k) of the texel maps (3,4,k): `deep` (k,) under the plane, whose light is
        bent, or over it, whose light is mirrored."""
        n = self._n[:, None]
        out = p - self._position[:, None]
        out -= n * dot(n, out)
        r = np.sqrt(dot(out, out))
        x = entry(r, self.height, deep, self._eta) if below else r * self.height / (self.height + deep)
        away = np.sqrt(x * x + self.height**2)
        cos_i = self.height / away
        d = out * (x / np.maximum(r * away, _TINY)) - n * cos_i
        if below:
            cos_t = cosine_refracted(cos_i, self._eta)
            gamma, turn = cos_i / self._eta - cos_t, 1 / self._eta - cos_i / (cos_t * self._eta**2)
            t, along, bend = d / self._eta + gamma * n, cos_t, np.abs(gamma)
        else:
            t, along, turn, bend = d + 2 * cos_i * n, cos_i, 2.0, 2 * cos_i
        scale = 1 / self._eta if below else 1.0
        fall = dot(maps[0, :3], t)
        fall = np.where(fall < 0, -1.0, 1.0) * np.sqrt(fall**2 + (self._slope * bend) ** 2 + np.finfo(float).eps)
        moments = np.zeros((3, len(r)))
        for delta in self._extent[:, :, None]:
            turned = (d * dot(d, delta) - delta) / away
            bent = turned * scale - n * (turn * dot(n, turned))
            slide = (bent - t * (dot(maps[0, :3], bent) / fall)) * (deep / along)
            u, v = dot(maps[1, :3], slide), dot(maps[2, :3], slide)
            moments += u * u, v * v, u * v
        return moments
