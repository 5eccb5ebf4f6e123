"""The plainest of all: suns, still water, and one plane below with nothing between. Its light is one number, and its
outline that of the water."""

from __future__ import annotations

import numpy as np

from ..maps.coverage import edge_coverage
from ..scene import Sun
from ..solution import book
from ..splat.plane import floor_plane
from .doubt import Border, Doubt, some
from .paths import paths

_LEVEL = 1e-6  # slope between floor and water, at most, where light is absorbed by depth


class OneFloor:
    """One planar receiver of a Scene under a Still plane; see `of`."""

    def __init__(self, still, scene, own, plane):
        self._still, self._scene, self._own, self._plane = still, scene, own, plane
        self._normal = still.frame @ own.normals[0]
        points = own.positions[some(len(own.texel))]
        self._points, self._texel = still.to_plane(points), np.sqrt(own.area.mean())

    @classmethod
    def of(cls, still, scene, texels):
        """The OneFloor of a Scene, None for one that is not so plain."""
        if not all(isinstance(light, Sun) for light in scene.lights):
            return None
        plane = floor_plane(scene, texels)
        if plane is None or (still.to_plane(scene.receivers[0].positions)[2] >= 0).any():
            return None
        floor = cls(still, scene, texels[0], plane)
        if np.any(scene.sigma_a) and np.hypot(*floor._normal[:2]) > _LEVEL:
            return None
        return floor

    def under(self, light, work):
        """Irradiance (K,3) of a Sun and its Doubts, in the mean over texels; books what comes in."""
        still, scene = self._still, self._scene
        count, power = len(self._own.texel), np.asarray(light.irradiance, float)
        ways = paths(still, light, self._points, scene.eta, True)
        if ways is None:
            return np.zeros((count, 3)), ()
        passed = float(ways.strength[0])
        e = passed * max(-(self._normal @ ways.arrives[:, 0]), 0.0)
        kept = np.exp(-np.asarray(scene.sigma_a) * ways.length.mean())
        share = self._shares(ways.arrives[:, 0])
        cos_i, cos_t = float(ways.towards[2, 0]), float(-ways.arrives[2, 0])
        met = still.area() * cos_i * power
        through = still.area() * passed * cos_t * power
        watts = e * power * (share @ self._own.area)
        lost = {"reflected": met - through, "absorbed": watts * (1 - kept), "missed": through - watts}
        book(work, lost, met)
        light_there = (e * power * kept).mean()
        border = Border(light_there**2 * np.mean((share > 0) & (share < 1)), self._texel)
        each = np.full(self._points.shape[1], light_there)
        irradiance = np.empty((count, 3))
        irradiance[:] = e * power * kept
        part = np.flatnonzero(share < 1)
        irradiance[part] *= share[part, None]
        return irradiance, (Doubt(light, ways, each, scene.eta, True, border, 1 / len(each)),)

    def _shares(self, t):
        """How much (K,) of each texel lies in light that passes the water along t (3,)."""
        side, ends = self._own.resolution, []
        t = t @ self._still.frame
        for end in self._still.rim:
            m = self._still.to_world(np.concatenate([end, np.zeros((1, end.shape[1]))])).T
            height, *at = self._plane[:, :3] @ m + self._plane[:, 3:]
            fall, *way = self._plane[:, :3] @ t
            ends.append(np.stack([a - height / fall * w for a, w in zip(at, way, strict=True)]))
        share = np.abs(edge_coverage(*ends, np.ones((1, ends[0].shape[1])), (side, side))[0].ravel())
        np.minimum(share, 1.0, out=share)
        return share if len(self._own.texel) == len(share) else share[self._own.texel]
