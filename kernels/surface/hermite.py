"""Points and normals between vertices whose normals, and their turns, are known: cubics along edges and triangles.

An edge leaves its ends along their tangent planes, so long that arcs of circles come out round; along it the normals
are cubics too, from their turns at the ends. Inside, the triangle's Bezier cubic has the middle control point that
reproduces quadratics [1]. An edge depends on its own ends only: nothing opens between triangles.

[1] Vlachos, Peters, Boyd & Mitchell 2001, Curved PN triangles.
"""

from __future__ import annotations

import numpy as np


def between_corners(positions, normals, turns, shares):
    """Positions and normals (6,n,m), not unit, at the convex combinations shares (c,m) of c = 1, 2 or 3 corners with
    positions and normals (3,c,n) and turns (3,3,c,n)."""
    corners = positions.shape[1]
    values = np.concatenate([positions, normals])
    out = sum(values[:, i, :, None] * shares[i] ** 3 for i in range(corners))
    edges = np.zeros_like(values[:, 0])
    for i in range(corners):
        for j in range(corners):
            if i != j:
                control = values[:, i] + _leaving(positions, normals, turns, i, j) / 3
                out += control[..., None] * (3 * shares[i] ** 2 * shares[j])
                edges += control
    if corners == 3:
        middle = edges / 4 - values.sum(1) / 6
        out += middle[..., None] * (6 * shares[0] * shares[1] * shares[2])
    return out


def _leaving(positions, normals, turns, i, j):
    """Derivatives (6,n) of position and normal at corner i of the edge to corner j, from 0 there to 1."""
    chord = positions[:, j] - positions[:, i]
    along = chord - (chord * normals[:, i]).sum(0) * normals[:, i]
    length, flat = np.sqrt((chord**2).sum(0)), np.sqrt((along**2).sum(0))
    along = along * (2 * length**2 / np.maximum(flat * (length + flat), np.finfo(float).tiny))
    return np.concatenate([along, np.einsum("ijn,jn->in", turns[:, :, i], along)])
