"""Photons that leave the water: stratified over its lit triangles, refracted at the interpolated normal, in blocks.

A photon is the flux of its stratum. Positions and normals are linear over a triangle, so a block of them is one matrix
product (see `strata.py`); what differs between receivers is only the set of linear forms that is asked for.
"""

from __future__ import annotations

import numpy as np

from ..optics import cosine_refracted, fresnel_transmittance
from .strata import linear, squared_length, strata

BLOCK = 1 << 13  # photons at once: the dozen arrays of a block stay in the second-level cache


def batches(lit, photons, rng):
    """Yield (triangles, monomials, flux) for about `photons` photons over a LitWater, or more: one at least in each lit
    triangle.

    triangles (n,) ids, monomials (6, m) of the points that they share, flux (n,) [W for 1 W/m^2] of each photon.
    """
    ids = np.flatnonzero(lit.area)
    if not len(ids):
        return
    wanted = lit.area[ids] * (photons / lit.area.sum())
    side = np.maximum(1, np.ceil(np.sqrt(wanted) - 1e-9)).astype(np.int64)
    for m in np.unique(side):
        group = ids[side == m]
        step = max(1, BLOCK // (m * m))
        points = None
        for start in range(0, len(group), step):
            block = group[start : start + step]
            if points is None or step > 8:  # fresh points for every block, unless making them would cost more
                points = strata(m, rng)
            for k in range(0, m * m, BLOCK):
                yield block, points[:, k : k + BLOCK], lit.area[block] / (m * m)


class Forms:
    """Linear forms of position and normal over the water, ready to be evaluated at a block's photons.

    position_forms, normal_forms (n,3): rows that are applied to the LitWater's positions and normals.
    """

    def __init__(self, lit, position_forms, normal_forms):
        on_positions = [linear(values, lit.triangles) for values in np.asarray(position_forms) @ lit.positions.T]
        along_sun = lit.normals[:, 2]
        on_normals = [linear(values, lit.normal_triangles) for values in np.asarray(normal_forms) @ lit.normals.T]
        on_normals.append(linear(along_sun, lit.normal_triangles))
        self._linear = np.stack([*on_positions, *on_normals], 1)
        self._squared = squared_length(lit.normals, lit.normal_triangles)

    def at(self, triangles, monomials):
        """Values (n + n + 1, N) of the forms and of N.s, and |N|^2 (N,), at N = len(triangles) * m photons."""
        coefficients = np.take(self._linear, triangles, axis=0)
        count = coefficients.shape[1]
        values = np.empty((count, len(triangles), monomials.shape[1]))
        for k in range(count):
            np.matmul(coefficients[:, k], monomials[:3], out=values[k])
        squared = np.take(self._squared, triangles, axis=0) @ monomials
        return values.reshape(count, -1), squared.ravel()


def bend(along_sun, squared, eta, fresnel=True):
    """What refraction does at normals N, not normalised: g (n,) with t = d / eta + g N, and the transmittance (n,), 1
    without `fresnel`.

    along_sun (n,) = N.s, squared (n,) = |N|^2. Light that meets the back of a normal passes nothing: T = 0.
    """
    inverse = _inverse_length(squared)
    cos_i = np.maximum(along_sun * inverse, 0.0)
    cos_t = cosine_refracted(cos_i, eta)
    g = (cos_i / eta - cos_t) * inverse
    front = cos_i > 0
    return g, fresnel_transmittance(cos_i, cos_t, eta) * front if fresnel else front.astype(float)


def bounce(along_sun, squared, eta):
    """What reflection does at normals N, as `bend`: g (n,) with t = d + g N, and the reflectance (n,), 1 - T.

    Light that meets the back of a normal is lost.
    """
    inverse = _inverse_length(squared)
    cos_i = np.maximum(along_sun * inverse, 0.0)
    transmittance = fresnel_transmittance(cos_i, cosine_refracted(cos_i, eta), eta)
    return 2 * cos_i * inverse, (1 - transmittance) * (cos_i > 0)


def _inverse_length(squared):
    return 1 / np.sqrt(np.maximum(squared, np.finfo(float).tiny))
