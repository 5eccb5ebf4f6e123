"""What a refracted path carries: irradiance at P through M, from the ray's footprint.

Moving M by dM moves the refracted ray's landing point by W = dM + tau dt. The flux through a small parallelogram of the
water lands on the parallelogram of the two W, so

    E = E_perp T |t.n_r| |d.(E1 x E2)| / |t.(W1 x W2)|

with E1, E2 the triangle's edges. It is the area of the geometry that is lit, on the sun's side, and the shading normal
that bends: this pairing conserves the flux of facets with interpolated normals. After [Walter et al. 2009, Single
Scattering in Refractive Media] by differentials of the ray, forward instead of backward.
"""

from __future__ import annotations

import numpy as np

from ..optics import cosine_refracted, fresnel_transmittance


def path_irradiance(surface, triangle, weights, p, receiver_normal, eta):
    """What arrives of paths through barycentric `weights` (n,3) of triangles (n,) at p (3,n), as two factors of E for
    E_perp = 1: the transmittance (n,), and how densely the light falls (n,) [m^2 across the light per m^2 of the
    receiver], negative where the image of the triangle is turned against the triangle, infinite on a fold; and the
    length (n,) [m] of the way through the water.

    receiver_normal (3,n) in the light's frame, either side.
    """
    r = 1 / eta
    corner_m, corner_n = surface.corners(triangle)
    share = weights.T[:, None]
    m, big_n = (share * corner_m).sum(0), (share * corner_n).sum(0)
    length = np.sqrt((big_n**2).sum(0))
    n = big_n / length
    cos_i = n[2]
    cos_t = cosine_refracted(cos_i, eta)
    gamma = r * cos_i - cos_t
    t = gamma * n
    t[2] -= r  # t = r d + gamma n, and d = -z
    tau = np.sqrt(((p - m) ** 2).sum(0))
    spread = []
    for i in (1, 2):
        n_i = (corner_n[i] - corner_n[0]) / length
        n_i -= (n * n_i).sum(0) * n
        c_i = n_i[2]
        t_i = gamma * n_i + (r - r * r * cos_i / cos_t) * c_i * n
        spread.append(corner_m[i] - corner_m[0] + tau * t_i)
    footprint = (t * np.cross(spread[0], spread[1], axis=0)).sum(0)
    e1, e2 = corner_m[1] - corner_m[0], corner_m[2] - corner_m[0]
    lit = np.abs(e1[0] * e2[1] - e1[1] * e2[0])
    facing = np.abs((t * receiver_normal).sum(0))
    with np.errstate(divide="ignore"):
        return fresnel_transmittance(cos_i, cos_t, eta), facing * lit / footprint, tau
