"""What one smooth interface does to light, from either side: Snell, Fresnel, total internal reflection, Schlick.

[1] Born & Wolf, Principles of Optics, 1.5.2 and 1.5.4: Fresnel formulae and total reflection.
[2] Schlick 1994, An inexpensive BRDF model for physically-based rendering, eq. 15.
"""

from __future__ import annotations

import numpy as np


def fresnel(cos_i, ratio):
    """Cosine of refraction and share of unpolarised light that is reflected, (k,) both, for cosines of incidence
    cos_i (k,) and ratio = n_before / n_after; beyond the critical angle they are 0 and 1. [1]"""
    cos_t = np.sqrt(np.maximum(1 - ratio * ratio * (1 - cos_i * cos_i), 0))
    a, b = ratio * cos_i, ratio * cos_t
    r_s = (a - cos_t) / (a + cos_t)
    r_p = (cos_i - b) / (cos_i + b)
    return cos_t, (r_s * r_s + r_p * r_p) / 2


def schlick(cos_i, f0, f90):
    """Share (C,k) of light that a mirror reflects, of its reflectance f0 along the normal and f90 at grazing incidence,
    (C,k) or (C,1). [2]"""
    return f0 + (f90 - f0) * (1 - cos_i) ** 5


def refracted(direction, normal, cos_i, cos_t, ratio, side=1.0):
    """Directions (3,k) of what passes; normal (3,k) unit, times side (k,), 1 or -1, against the direction (3,k)."""
    bent = ratio * direction
    bent += ((ratio * cos_i - cos_t) * side) * normal
    return bent


def reflected(direction, normal, cos_i, side=1.0):
    """Directions (3,k) of what is turned back; normal (3,k) and side as in `refracted`."""
    return direction + (2 * cos_i * side) * normal
