"""Stratified points in triangles: m^2 congruent sub-triangles, one point in each, the same for a block of triangles.

Sharing the points between the triangles of a block turns every quantity that is linear, or quadratic, over a triangle
into one matrix product: coefficients (T, 3 or 6) times BASIS (3 or 6, m^2).
"""

from __future__ import annotations

import numpy as np


def strata(m, rng):
    """Barycentric a, b of m^2 points, one uniform in each of the triangle's congruent m^2 parts, as the monomials
    (6, m^2): 1, a, b, a^2, a b, b^2."""
    i, j = np.divmod(np.arange(m * m), m)
    u, v = rng.random((2, m * m))
    over = u + v > 1
    u, v = np.where(over, 1 - u, u), np.where(over, 1 - v, v)
    # Cells of the square below its diagonal are the upright parts; those above, mirrored, the inverted ones.
    inverted = i + j >= m
    i, j = np.where(inverted, m - 1 - i, i), np.where(inverted, m - 1 - j, j)
    a = np.where(inverted, i + 1 - u, i + u) / m
    b = np.where(inverted, j + 1 - v, j + v) / m
    return np.stack([np.ones_like(a), a, b, a * a, a * b, b * b])


def linear(values, triangles):
    """Coefficients (T, 3) of 1, a, b for vertex values (V,) over triangles (T,3)."""
    v0, v1, v2 = (np.take(values, triangles[:, k]) for k in range(3))
    return np.stack([v0, v1 - v0, v2 - v0], 1)


def squared_length(vectors, triangles):
    """Coefficients (T, 6) of the monomials for |v|^2 of vertex vectors (V,3), interpolated linearly."""
    v0, v1, v2 = (np.take(vectors, triangles[:, k], axis=0) for k in range(3))
    v1, v2 = v1 - v0, v2 - v0
    dot = [(p * q).sum(1) for p, q in ((v0, v0), (v0, v1), (v0, v2), (v1, v1), (v1, v2), (v2, v2))]
    return np.stack([dot[0], 2 * dot[1], 2 * dot[2], dot[3], 2 * dot[4], dot[5]], 1)
