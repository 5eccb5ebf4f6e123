"""The plainest scene, and the most common: one plane that fills its lightmap, and nothing between it and the water."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..optics import dot
from .carried import Rows
from .lander import MISSED, Nodes, texel_maps
from .photons import bend

_FEW = 64  # triangles
_FLAT = 1e-5  # of the map's side: how far a receiver's corners may be from one plane and one affine map


def one_plane(scene, texels):
    """The affine map (3,4) from the world to height [m] and texel coordinates of a scene that is one planar receiver
    with whole texels, all the water before its front and nothing in the way, else None; see `lander.texel_maps`."""
    widest = floor_plane(scene, texels)
    if widest is None:
        return None
    return widest if (scene.water.positions @ widest[0, :3] + widest[0, 3] > 0).all() else None


def floor_plane(scene, texels):
    """As `one_plane`, wherever the water is."""
    if len(scene.receivers) != 1 or scene.occluders or scene.casters:
        return None
    receiver, own = scene.receivers[0], texels[0]
    few = slice(None, None, len(receiver.triangles) // _FEW + 1)
    some = replace(receiver, triangles=receiver.triangles[few], uvs=receiver.uvs[few])
    for part in (some, receiver):  # uneven ground shows in a few triangles
        widest = _common_map(part, own.resolution)
        if widest is None:
            return None
    return widest if own.whole[own.texel].all() else None


def _common_map(receiver, resolution):
    """The affine map of all of a Receiver's triangles, None where they have none in common."""
    maps = texel_maps(receiver, resolution)
    widest = maps[np.argmax(np.abs(maps[:, 0, :3]).sum(1))]
    v = receiver.positions[receiver.triangles].reshape(-1, 3)
    image = v @ widest[:, :3].T + widest[:, 3]
    per_metre = np.linalg.norm(widest[1, :3])
    off = np.abs(image[:, 1:] - receiver.uvs.reshape(-1, 2) * resolution).max(initial=0)
    far = max(off, np.abs(image[:, 0]).max(initial=0) * per_metre) > _FLAT * resolution
    return None if far else widest


class PlaneLander:
    """As `lander.Lander`, without a ray: where refracted light meets the plane, within its map or beyond.

    plane (3,4) from `one_plane`; chart (T,) of the receiver's triangles, which count as one here; source: that of a Sun
    or a Point; eta and sigma_a (3,) of the water; fresnel: refract by it.
    """

    certain, hides, grazing, again, fine = True, False, False, 0, 1.0

    def __init__(self, plane, chart, source, eta, sigma_a, fresnel=True):
        self.image = np.zeros(chart.max(initial=0) + 1, np.int64)
        self.plane, self._source, self._eta, self.fresnel = plane, source, eta, fresnel
        self.rows = Rows(sigma_a, source)

    def weight(self, _chart, _x, _y):
        """As `lander.Lander.weight`."""
        return None

    def land(self, m, n, _shadowed):
        """Nodes of points m (3,k) with normals n (3,k), in the world."""
        towards, _, met = self._source.incident(m)
        g, share = bend(dot(towards, n), dot(n, n), self._eta, self.fresnel)
        linear, offset = self.plane[:, :3], self.plane[:, 3:]
        height, x, y = linear @ m + offset
        fall, dx, dy = (linear @ n) * g - linear @ towards / self._eta
        with np.errstate(divide="ignore", invalid="ignore"):  # light along the plane
            tau = -height / fall
            x, y = x + tau * dx, y + tau * dy
        meets = (tau > 0) & np.isfinite(x) & np.isfinite(y) & (share > 0)  # nothing passes at the back of normals
        x, y = np.where(meets, x, 0.0), np.where(meets, y, 0.0)
        carried = self.rows.of(met, share, tau, meets)
        return Nodes(m, n, np.where(meets, 0, MISSED), x, y, np.ones(len(x)), carried)
