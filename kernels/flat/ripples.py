"""What the waves that still water lacks would do to the light: the error of leaving them out, to first order.

A slope s of the water moves the light that passes there by tau G s when it has gone tau further; so curvature H = ds/dx
gathers it, and the light at the texel differs from that of still water by the factor

    1 + s . f - tau tr(G H) / m

with m how much wider beams are there than at the water, r = 1 / eta, d the light's direction in the plane of the water,

    G = -gamma I + (r kappa / cos t) d d^T,   gamma = r cos i - cos t,   kappa = r - r^2 cos i / cos t,

or mirrored G = -2 cos i I - (2 / cos i) d d^T; f is what slopes change of the flux that enters there. These are the
differentials of Snell's law (see `walk/path_irradiance.py`) at level water. The next order adds as much as the square
of this.
"""

from __future__ import annotations

import numpy as np

from ..optics import cosine_refracted, fresnel_transmittance

_TRIANGLES = 1 << 11  # that are looked at, about: twice or four times as many tell the same within a twentieth
_CELLS = 16  # along each side of what is lit, in which waves are taken as alike
_STEP = 1e-4  # of the cosine, for the slope of Fresnel's curve
_STEEPEST = 1e-3  # cosine between a normal and the plane's, at least
_TINY = np.finfo(float).tiny


class Ripples:
    """Waves of a Still plane where light passes to `ways`, Paths through the plane or off it.

    blur [m]: over how wide a piece of the plane a texel and the light's disc take the mean.
    """

    def __init__(self, still, ways, eta, through, blur):
        self._low, high = ways.enters.min(1) - blur, ways.enters.max(1) + blur
        self._cell = np.maximum((high - self._low) / _CELLS, _TINY)
        place, slope, curve, area = _sampled(still, self._low, high)
        d = -ways.towards.mean(1)
        f, g = _differentials(d / np.linalg.norm(d), eta, through)
        moved = g @ slope
        values = np.stack([f @ slope, (g[:, :, None] * curve.transpose(1, 0, 2)).sum((0, 1)), (moved * moved).sum(0)])
        place, values, area = _means(place, values, area, blur)
        flux, bend, self.moved = values
        self._squares = self._alike(place, np.stack([flux * flux, flux * bend, bend * bend, self.moved]), area)

    def squared(self, ways):
        """Relative squared change (n,) that the waves make where Paths end, in the mean, and the squared distance (n,)
        [m^2] by which they move light there."""
        alike = np.take(self._squares, self._index(ways.enters), axis=1)
        bent = ways.length / ways.spread
        return alike[0] - 2 * bent * alike[1] + bent**2 * alike[2], ways.length**2 * alike[3]

    def _index(self, place):
        column, row = np.clip((place - self._low[:, None]) / self._cell[:, None], 0, _CELLS - 1).astype(np.int64)
        return row * _CELLS + column

    def _alike(self, place, values, area):
        """Means (k, cells) by area of values (k,n) at places (2,n); where none is, the mean of all."""
        index = self._index(place)
        weight = np.bincount(index, area, _CELLS**2)
        total = np.stack([np.bincount(index, area * v, _CELLS**2) for v in values])
        overall = total.sum(1, keepdims=True) / max(weight.sum(), _TINY)
        return np.where(weight > 0, total / np.maximum(weight, _TINY), overall)


def _sampled(still, low, high):
    """Middles (2,n) in the plane, slopes (2,n) there, their derivatives (2,2,n) along the plane and plan areas (n,) of
    some triangles that reach between `low` and `high` (2,), those that face up."""
    water = still.water
    some = np.arange(0, len(water.triangles), len(water.triangles) // (4 * _TRIANGLES) | 1)
    ids, corner = _near(still, some, low, high)
    if len(ids) < _TRIANGLES and len(water.triangles) > 4 * _TRIANGLES:
        ids, corner = _near(still, np.arange(len(water.triangles)), low, high)
    some = slice(None, None, len(ids) // _TRIANGLES | 1)
    ids, corner = ids[some], corner[..., some]
    normal = np.take(water.normals, water.normal_triangles[ids].ravel(), axis=0)
    normal = (still.frame @ normal.T).reshape(3, -1, 3)
    normal = normal * np.where(normal[2].sum(1) < 0, -1.0, 1.0)[None, :, None] if _downward(normal) else normal
    faces = normal[2].sum(1) > 0
    corner, normal = corner[:, :, faces], normal[:, faces]
    slope = (-normal[:2] / np.maximum(normal[2], _STEEPEST)).transpose(0, 2, 1)
    e1, e2 = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    across = e1[0] * e2[1] - e1[1] * e2[0]
    safe = np.where(across == 0, np.inf, across)
    to_b, to_c = np.stack([e2[1], -e2[0]]) / safe, np.stack([-e1[1], e1[0]]) / safe
    rise_b, rise_c = slope[:, 1] - slope[:, 0], slope[:, 2] - slope[:, 0]
    curve = rise_b[:, None] * to_b[None] + rise_c[:, None] * to_c[None]
    return corner.mean(1), slope.mean(1), curve, np.abs(across) / 2


def _near(still, ids, low, high):
    """Those of triangles ids (n,) that reach between `low` and `high` (2,) in the plane, and their corners (2,3,m)."""
    corner = np.take(still.water.positions, still.water.triangles[ids].T.ravel(), axis=0)
    corner = (still.frame[:2] @ (corner - still.origin).T).reshape(2, 3, -1)
    least, most = (reach(reach(corner[:, 0], corner[:, 1]), corner[:, 2]) for reach in (np.minimum, np.maximum))
    near = np.logical_and.reduce((most >= low[:, None]) & (least <= high[:, None]))
    return (ids, corner) if near.all() else (ids[near], corner[:, :, near])


def _downward(normal):
    """Whether normals (3,n,3) look down on the whole: the water is wound the other way round."""
    return normal[2].sum() < 0


def _differentials(d, eta, through):
    """f (2,) and G (2,2) of light along d (3,) in the plane's coordinates."""
    cos_i, r = -d[2], 1 / eta
    flat = d[:2]

    def passed(c):
        share = fresnel_transmittance(c, cosine_refracted(c, eta), eta)
        return np.log(share if through else 1 - share)

    least, most = max(cos_i - _STEP, _STEP / 2), min(cos_i + _STEP, 1.0)
    fresnel = flat * (passed(most) - passed(least)) / (most - least)
    if not through:
        return 2 * flat / cos_i + fresnel, -2 * cos_i * np.eye(2) - 2 / cos_i * np.outer(flat, flat)
    cos_t = cosine_refracted(cos_i, eta)
    gamma, kappa = r * cos_i - cos_t, r - r * r * cos_i / cos_t
    return flat * (1 / cos_i - r / cos_t) + fresnel, -gamma * np.eye(2) + r * kappa / cos_t * np.outer(flat, flat)


def _means(place, values, area, blur):
    """Places (2,m), values (k,m) and areas (m,), in the mean over the cells of a grid of width `blur`."""
    if not place.size:
        return place, values, area
    column, row = ((place - place.min(1, keepdims=True)) / max(blur, _TINY)).astype(np.int64)
    _, cell = np.unique(row * (column.max() + 1) + column, return_inverse=True)
    weight = np.maximum(np.bincount(cell, area), _TINY)
    mean = [np.bincount(cell, area * v) / weight for v in (*place, *values)]
    return np.stack(mean[:2]), np.stack(mean[2:]), weight
