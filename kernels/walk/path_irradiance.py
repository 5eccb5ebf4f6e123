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

from ..optics import cosine_refracted, dot, fresnel_transmittance


def path_irradiance(surface, triangle, weights, p, receiver_normal, eta, fresnel=True):
    """What arrives of paths through barycentric `weights` (n,3) of triangles (n,) at p (3,n), as two factors of E for
    a light of power 1, see `sources`: the light that is met, times the transmittance (n,), and how densely it falls
    (n,) [m^2 of `LitWater.area` per m^2 of the receiver], negative where the image of the triangle is turned against
    the triangle, infinite on a fold; and the length (n,) [m] of the way through the water.

    receiver_normal (3,n) in the light's frame, either side; without `fresnel` all light passes.
    """
    r = 1 / eta
    corner_m, corner_n = surface.corners(triangle)
    e, n_e = ([c[i] - c[0] for i in (1, 2)] for c in (corner_m, corner_n))
    m, big_n = (c[0] + weights[:, 1] * v[0] + weights[:, 2] * v[1] for c, v in ((corner_m, e), (corner_n, n_e)))
    d = surface.arriving(m)
    over = 1 / np.sqrt(dot(big_n, big_n))
    n = big_n * over
    cos_i = -dot(d, n)
    cos_t = cosine_refracted(cos_i, eta)
    gamma = r * cos_i - cos_t
    t = gamma * n + r * d
    way = p - m
    tau = np.sqrt(dot(way, way))
    slope = r - r * r * cos_i / cos_t
    spread = []
    for e_i, n_i in zip(e, n_e, strict=True):
        n_i = n_i * over
        n_i -= dot(n, n_i) * n
        d_i = _turning(surface, m, d, e_i)
        c_i = -dot(d, n_i) - dot(d_i, n)
        t_i = gamma * n_i + slope * c_i * n + r * d_i
        spread.append(e_i + tau * t_i)
    (ux, uy, uz), (vx, vy, vz) = spread
    footprint = t[0] * (uy * vz - uz * vy) + t[1] * (uz * vx - ux * vz) + t[2] * (ux * vy - uy * vx)
    facing = np.abs(dot(t, receiver_normal))
    met = surface.met(m) * (fresnel_transmittance(cos_i, cos_t, eta) if fresnel else np.ones_like(cos_i))
    with np.errstate(divide="ignore"):
        return met, facing * 2 * surface.area[triangle] / footprint, tau


def _turning(surface, m, d, step):
    """How the light's direction d (3,n) at m (3,n) changes along `step` (3,n); not at all under a sun."""
    if surface.lamp is None:
        return np.zeros((3, 1))
    ray = m - surface.lamp[:, None]
    return (step - dot(d, step) * d) / np.sqrt(dot(ray, ray))
