"""Refraction at the water: Snell, Fresnel, and the frame of the sun.

[1] Born & Wolf, Principles of Optics, 1.5.2: Fresnel formulae.
"""

from __future__ import annotations

import numpy as np


def cosine_refracted(cos_i, eta):
    """Cosine of refraction for light that enters a medium of relative index eta > 1. Snell."""
    r = 1 / eta
    return np.sqrt(1 - r * r * (1 - cos_i * cos_i))


def fresnel_transmittance(cos_i, cos_t, eta):
    """Share of unpolarised flux that passes into the medium. [1] eqs. 20-21; both cosines positive."""
    a = eta * cos_t
    b = eta * cos_i
    r_s = (cos_i - a) / (cos_i + a)
    r_p = (b - cos_t) / (b + cos_t)
    return 1 - 0.5 * (r_s * r_s + r_p * r_p)


def dot(a, b):
    """Products (k,) of vectors (3,k), of which one may be (3,1)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def sun_frame(direction):
    """Rotation (3,3) whose rows are two axes across the light and s = -direction: x' = R x has light along -z."""
    s = -np.asarray(direction, float)
    helper = np.eye(3)[np.abs(s).argmin()]
    x = np.cross(helper, s)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(s, x), s])
