"""What a refracted path carries: irradiance at P through M, from the ray's footprint.

Moving M by dM moves the refracted ray's landing point by W = dM + tau dt. The flux through a small parallelogram of the
water lands on the parallelogram of the two W, so

    E = E_perp T |t.n_r| |d.(E1 x E2)| / |t.(W1 x W2)|

with E1, E2 the triangle's edges. Of a lamp at the distance R, E_perp is I / R^2 and d turns with M. It is the area of
the geometry that is lit, on the light's side, and the shading normal that bends: this pairing conserves the flux of
facets with interpolated normals. After [Walter et al. 2009, Single Scattering in Refractive Media] by differentials of
the ray, forward instead of backward.
"""

from __future__ import annotations

import numpy as np

from ..optics import cosine_refracted, fresnel_transmittance


def path_irradiance(surface, triangle, weights, p, receiver_normal, eta):
    """What arrives of paths through barycentric `weights` (n,3) of triangles (n,) at p (3,n), as two factors of E for
    a light of power 1, see `sources`: the light that is met, times the transmittance (n,), and how densely it falls
    (n,) [m^2 of `LitWater.area` per m^2 of the receiver], negative where the image of the triangle is turned against
    the triangle, infinite on a fold; and the length (n,) [m] of the way through the water.

    receiver_normal (3,n) in the light's frame, either side.
    """
    r = 1 / eta
    corner_m, corner_n = surface.corners(triangle)
    share = weights.T[:, None]
    m, big_n = (share * corner_m).sum(0), (share * corner_n).sum(0)
    d = surface.arriving(m)
    length = np.sqrt((big_n**2).sum(0))
    n = big_n / length
    cos_i = -(d * n).sum(0)
    cos_t = cosine_refracted(cos_i, eta)
    gamma = r * cos_i - cos_t
    t = gamma * n + r * d
    tau = np.sqrt(((p - m) ** 2).sum(0))
    spread = []
    for i in (1, 2):
        e_i, n_i = corner_m[i] - corner_m[0], (corner_n[i] - corner_n[0]) / length
        n_i -= (n * n_i).sum(0) * n
        d_i = _turning(surface, m, d, e_i)
        c_i = -(d * n_i).sum(0) - (d_i * n).sum(0)
        t_i = gamma * n_i + (r - r * r * cos_i / cos_t) * c_i * n + r * d_i
        spread.append(e_i + tau * t_i)
    footprint = (t * np.cross(spread[0], spread[1], axis=0)).sum(0)
    facing = np.abs((t * receiver_normal).sum(0))
    met = surface.met(m) * fresnel_transmittance(cos_i, cos_t, eta)
    with np.errstate(divide="ignore"):
        return met, facing * 2 * surface.area[triangle] / footprint, tau


def _turning(surface, m, d, step):
    """How the light's direction d (3,n) at m (3,n) changes along `step` (3,n); not at all under a sun."""
    if surface.lamp is None:
        return np.zeros((3, 1))
    distance = np.sqrt(((m - surface.lamp[:, None]) ** 2).sum(0))
    return (step - (d * step).sum(0) * d) / distance
