"""The coplanarity conic of a triangle with interpolated normals, in the frame of the sun.

For a point P and parallel light, the points M of a triangle where PM, the light and the normal N are coplanar form a
conic [1, eq. 9-12]. In a frame whose z points to the sun it is g = 0 with

    g(M) = N_x (M_y - P_y) - N_y (M_x - P_x),

a quadratic form over the triangle, and quadratic along an edge:  g(s) = g0 + (g1 - g0 - k) s + k s^2  with k = dN x dM
of the edge. At a vertex it costs four numbers. Signs of g at the vertices decide which edges the curve crosses, so
every triangle round an edge agrees, zero counting as positive.

[1] Granizo-Hidalgo & Holzschuch 2024, Interactive Rendering of Caustics using Dimension Reduction for Manifold
    Next-Event Estimation. Its edge equations 22-23 are misprinted; those here follow from eq. 12.
"""

from __future__ import annotations

import numpy as np

from ..halfedges import AFTER

ACROSS = np.array([[0.0, 1.0], [-1.0, -1.0], [1.0, 0.0]])  # gradient in (a, b) of the weight across from each edge
_STRAIGHT = 1e-3  # rad between chord and tangent
_TOUCHING = 1e-9  # in barycentric coordinates
FORWARD, BACKWARD = 1.0, -1.0
_AT_START = 1e-22  # |w_perp|^2 / |w|^2
_RESIDUAL = 1e-7  # |G| of a root, for unit normals: a root of a torn curve has more


def edge_root(p, q, k):
    """Where (n,), in 0..1, g crosses zero on edges with values p, q of opposite sign at their ends."""
    rise = q - p
    linear = rise - k
    root = np.sqrt(np.maximum(linear * linear - 4 * (k * p), 0))
    np.copysign(root, rise, out=root)  # the slope of g where it crosses
    bent = np.flatnonzero(linear * rise < 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = -2 * p / (linear + root)
        if len(bent):  # where the difference would cancel
            s[bent] = (root[bent] - linear[bent]) / (2 * k[bent])
    return np.fmin(np.fmax(s, 0), 1)


def has_double_root(p, q, k):
    """Whether (n,) g crosses zero twice on edges whose ends have values p, q of one sign."""
    linear = q - p - k
    return (linear * (linear + 2 * k) < 0) & (p * k > 0) & (linear * linear > 4 * k * p)


def edge_crossings(g, k):
    """Crossings s (n,3,2) of triangles' edges, ascending, NaN for none: g (n,3) at the corners, k (n,3) per edge."""
    p, q = g, g[:, AFTER]
    s = np.full((*g.shape, 2), np.nan)
    single = (p < 0) != (q < 0)
    s[single, 0] = edge_root(p[single], q[single], k[single])
    double = ~single & has_double_root(p, q, k)
    linear, k2 = (q - p - k)[double], k[double]
    root = np.sign(k2) * np.sqrt(linear * linear - 4 * k2 * p[double])
    s[double, 0], s[double, 1] = (-linear - root) / (2 * k2), (-linear + root) / (2 * k2)
    return s


def weights_on_edge(edge, s):
    """Barycentric weights (n,3) of share s along edges (n,) 0..2 of a triangle."""
    weights = np.zeros((len(edge), 3))
    row = np.arange(len(edge))
    weights[row, edge] = 1 - s
    weights[row, AFTER[edge]] = s
    return weights


def crossing_points(shares):
    """Points (n,6,2) a, b of crossings at shares (n,6), two for each edge; NaN stays."""
    edge = np.repeat(np.arange(3), 2)
    points = np.zeros((*shares.shape, 3))
    column = np.arange(6)
    points[:, column, edge] = 1 - shares
    points[:, column, AFTER[edge]] = shares
    return np.where(np.isnan(shares)[..., None], np.nan, points[..., 1:])


def conic(corner_m, corner_n, px, py):
    """Coefficients A..F (6,n) of g = A a^2 + B b^2 + C a b + D a + E b + F; corners (3,3,n) as corner, axis."""

    def cross(u, v):
        return u[0] * v[1] - u[1] * v[0]

    m0 = corner_m[0, :2] - np.stack([px, py])
    m1, m2 = corner_m[1, :2] - corner_m[0, :2], corner_m[2, :2] - corner_m[0, :2]
    n0 = corner_n[0, :2]
    n1, n2 = corner_n[1, :2] - n0, corner_n[2, :2] - n0
    return np.stack(
        [
            cross(n1, m1),
            cross(n2, m2),
            cross(n1, m2) + cross(n2, m1),
            cross(n0, m1) + cross(n1, m0),
            cross(n0, m2) + cross(n2, m0),
            cross(n0, m0),
        ]
    )


def tangent(coefficients, a, b):
    """Direction (2,n) of the conic at its points (a, b), of either sense, and the gradient (2,n)."""
    A, B, C, D, E, _ = coefficients
    gradient = np.stack([2 * A * a + C * b + D, C * a + 2 * B * b + E])
    return np.stack([-gradient[1], gradient[0]]), gradient


def follow(coefficients, start, along, gradient, shares, g):
    """First of a triangle's crossings that the conic meets when it leaves `start` in the direction `along`.

    coefficients (6,n); start (2,n) on the conic; along (2,n) tangent there; gradient (2,n); shares (n,6) of the
    crossings, two on each edge, NaN for none; g (n,3) at the corners. Returns the index (n,) of 0..5, and whether (n,)
    there is any. Where the curve leaves with g > 0 on its right, g falls along the triangle's rim; it rises where a
    curve comes in. That alone settles triangles with two crossings.
    """
    falls = np.stack([g >= 0, g < 0], 2).reshape(-1, 6)
    right = along[1] * gradient[0] - along[0] * gradient[1] > 0
    exits = ~np.isnan(shares) & (falls == right[:, None])
    index, count = exits.argmax(1), exits.sum(1)
    several = np.flatnonzero(count > 1)
    if len(several):
        points = np.where(exits[several, :, None], crossing_points(shares[several]), np.nan)
        arrays = (coefficients, start, along, gradient)
        index[several] = _first_along(*(a[:, several] for a in arrays), points)
    return index, count > 0


def _first_along(coefficients, start, along, gradient, points):
    """Index (n,) of the first of points (n,6,2), NaN for none, that the conic meets from `start`.

    A line through `start` meets the conic in one more point, so the points come in the order of their lines' angles
    from the tangent, turning to the side to which the conic bends, on ellipses and on both branches of hyperbolas.
    """
    A, B, C = coefficients[:3]
    bend = A * along[0] ** 2 + B * along[1] ** 2 + C * along[0] * along[1]
    side = np.where(bend > 0, -1.0, 1.0)
    chord = points - start.T[:, None]
    forth = chord[..., 0] * along[0][:, None] + chord[..., 1] * along[1][:, None]
    aside = (chord[..., 0] * gradient[0][:, None] + chord[..., 1] * gradient[1][:, None]) * side[:, None]
    angle = np.arctan2(aside, forth) % np.pi
    # Nearly straight: rounding turns the line either way, but near comes before far, and ahead before behind.
    reach = _STRAIGHT * np.abs(chord).max(2)
    straight = (angle < _STRAIGHT) | (angle > np.pi - _STRAIGHT)
    angle = np.where(straight, np.where(forth > 0, reach, np.pi - reach), angle)
    # On the very edge: met at once by a curve that leaves there, last by one that comes in.
    outward = -(ACROSS @ along).T.repeat(2, axis=1)
    touching = np.abs(chord).max(2) < _TOUCHING
    angle = np.where(touching, np.where(outward > 0, -1.0, 2 * np.pi), angle)
    return np.where(np.isnan(angle), np.inf, angle).argmin(1)


def objective(m, n, p, eta, sense):
    """The signed function f (n,) whose zeros on the conic are refracted paths; positive where the curve leaves M0.

    m, n, p (3,n): point and normal on the water, receiver point; sense: FORWARD on the way from M0 that the normal
    leans to, BACKWARD on the other. With w = P - M, u = w / |w| and u.d = -u_z, a path obeys

        G = N_perp (eta u.d - 1) + eta N_z u_perp = 0,    Snell's law across the light.

    On the conic G is parallel to w_perp, which vanishes nowhere on the curve but at M0; so f is |w| G along -w_perp on
    the one way and along w_perp on the other, and is continuous. No refraction is computed, and none can fail.
    """
    towards, across, along, at_start = _towards(m, n, p, eta)
    f = -sense * towards / np.sqrt(np.where(at_start, 1.0, across))
    return np.where(at_start, np.sqrt(n[0] * n[0] + n[1] * n[1]) * along, f)


def is_negative(m, n, p, eta, sense):
    """Whether (n,) `objective` is below zero."""
    towards, _, along, at_start = _towards(m, n, p, eta)
    negative = towards > 0 if sense > 0 else towards < 0
    if at_start.any():
        negative = np.where(at_start, (along < 0) & ((n[0] != 0) | (n[1] != 0)), negative)
    return negative


def _towards(m, n, p, eta):
    """|w| G along w_perp times its length (n,), |w_perp|^2, |w| (eta u.d - 1), and whether (n,) w_perp is rounding, as
    at M0, where f has that for its limit, times |N_perp|."""
    wx, wy, wz = p[0] - m[0], p[1] - m[1], p[2] - m[2]
    across = wx * wx + wy * wy
    length2 = across + wz * wz
    along = np.sqrt(length2)
    along += eta * wz
    np.negative(along, out=along)
    wx *= n[0]
    wy *= n[1]
    wx += wy
    wx *= along
    wx += eta * n[2] * across
    length2 *= _AT_START
    return wx, across, along, across < length2


def is_path(m, n, p, eta):
    """Whether (n,) a zero of f is light: G vanishes, u bends the right way, u.d > 1 / eta and N_perp . u_perp <= 0."""
    w = [p[i] - m[i] for i in range(3)]
    length = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
    along, lift = -eta * w[2] - length, eta * n[2]
    residual = np.abs(n[0] * along + lift * w[0]) + np.abs(n[1] * along + lift * w[1])
    towards = n[0] * w[0] + n[1] * w[1]
    slack = 1e-9 * length
    bent = (-w[2] > length / eta - slack) & (towards <= slack) & (n[2] > 0)
    return bent & (residual < _RESIDUAL * length)
