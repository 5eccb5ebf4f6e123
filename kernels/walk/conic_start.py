"""Where a walk starts: the straight ray to the sun, the conic through its hit, and the two ways along it.

The point M0 where the ray from P to the sun passes the water is on the curve [1, 3.4.2]. Light bends towards the
normal, so the root lies first on the side that the normal leans to; the other side is tried after it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import AFTER
from .conic import FORWARD, conic, edge_crossings, follow, objective, tangent, weights_on_edge
from .conic_root import fan

_MOVES = 3  # triangles that rounding may have put M0 off
_ON_EDGE = 1e-3  # barycentric
_UPRIGHT = 1e-14  # |N_perp|^2 / |N|^2 under which M0 itself is the path


@dataclass
class Start:
    """First arcs (n,) from M0: triangle, weights (n,3) of M0; upright (n,) bool, M0 is the root; closed (n,) bool, the
    conic does not leave the triangle; forward and backward exits as edge (n,) and share s (n,); p (3,n)."""

    triangle: np.ndarray
    weights: np.ndarray
    upright: np.ndarray
    closed: np.ndarray
    forward: tuple[np.ndarray, np.ndarray]
    backward: tuple[np.ndarray, np.ndarray]
    p: np.ndarray

    def fan(self):
        """As `conic_root.fan`, for the arc from M0 to either exit."""
        one, other = self.backward, self.forward
        apex, turn = fan(one[0], weights_on_edge(*one), other[0], weights_on_edge(*other))
        # From inside the triangle the lines turn by less than half a turn; from its edge they need the way to go.
        return apex, np.where(self.weights.min(1)[:, None] < _ON_EDGE, turn, 0.0)


def locate(surface, triangle, px, py):
    """Triangle (n,) that holds (px, py) in the sun's view, and barycentric weights (n,3), from a float32 hit."""
    triangle = triangle.copy()
    for _ in range(_MOVES):
        weights = _plan_weights(surface, triangle, px, py)
        edge = AFTER[weights.argmin(1)]  # the edge across from the most negative corner
        over = surface.over[3 * triangle + edge]
        out = (weights.min(1) < 0) & (over >= 0)
        if not out.any():
            break
        triangle[out] = over[out] // 3
    weights = np.clip(_plan_weights(surface, triangle, px, py), 0, 1)
    return triangle, weights / weights.sum(1, keepdims=True)


def _plan_weights(surface, triangle, px, py):
    corner = surface.corner_records(triangle).T
    x, y = np.take(surface.m[0], corner) - px, np.take(surface.m[1], corner) - py
    weights = np.stack([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]], 1)
    total = weights.sum(1, keepdims=True)
    return weights / np.where(total == 0, 1, total)


def begin(surface, triangle, p):
    """The Start of walks from receiver points p (3,n) whose straight ray hits `triangle` (n,)."""
    triangle, weights = locate(surface, triangle, p[0], p[1])
    corner_m, corner_n = surface.corners(triangle)
    normal = (weights.T[:, None] * corner_n).sum(0)
    lean = normal[0] ** 2 + normal[1] ** 2
    upright = lean <= _UPRIGHT * (lean + normal[2] ** 2)
    coefficients = conic(corner_m, corner_n, p[0], p[1])
    here = weights[:, 1:].T
    along, gradient = tangent(coefficients, *here)
    along = _leaning(along, corner_m, normal)
    g = surface.g_at_corners(triangle, p[0], p[1])
    shares = edge_crossings(g, surface.k.reshape(-1, 3)[triangle]).reshape(-1, 6)
    forward, some = follow(coefficients, here, along, gradient, shares, g)
    backward, _ = follow(coefficients, here, -along, gradient, shares, g)
    row = np.arange(len(triangle))
    ways = [(index // 2, shares[row, index]) for index in (forward, backward)]
    return Start(triangle, weights, upright, ~some, *ways, p)


def _leaning(along, corner_m, normal):
    """The tangent `along` (2,n), barycentric, turned to the side to which the normal (3,n) leans."""
    e1, e2 = corner_m[1] - corner_m[0], corner_m[2] - corner_m[0]
    lean = sum((along[0] * e1[i] + along[1] * e2[i]) * normal[i] for i in (0, 1))
    return along * np.where(lean < 0, -1.0, 1.0)


def closed_curve_root(surface, triangle, weights, p, eta, samples=64):
    """Weights (n,3) of the first root on conics that stay inside their triangle, NaN where there is none.

    Every line through M0 meets the ellipse in one more point, so the direction of the line runs through the whole
    curve, once in half a turn, starting and ending at M0.
    """
    corner_m, corner_n = surface.corners(triangle)
    coefficients = conic(corner_m, corner_n, p[0], p[1])
    here = weights[:, 1:].T
    along, gradient = tangent(coefficients, *here)

    # Leave M0 on the side that the normal leans to, and turn to the side to which the curve bends.
    along = _leaning(along, corner_m, (weights.T[:, None] * corner_n).sum(0))
    A, B, C = coefficients[:3]
    side = -np.sign(A * along[0] ** 2 + B * along[1] ** 2 + C * along[0] * along[1])

    def point(t):
        c, s = np.cos(np.pi * t), side * np.sin(np.pi * t)
        wa, wb = c * along[0] + s * gradient[0], c * along[1] + s * gradient[1]
        bend = A * wa * wa + B * wb * wb + C * wa * wb
        # A curve that has shrunk to M0 has no slope and no other point.
        sigma = -np.divide(wa * gradient[0] + wb * gradient[1], bend, out=np.zeros_like(bend), where=bend != 0)
        a, b = here[0] + sigma * wa, here[1] + sigma * wb
        return np.stack([1 - a - b, a, b], 1)

    def value(t):
        return objective(*surface.at(triangle, point(t)), p, eta, FORWARD)

    return point(_first_sign_change(value, len(triangle), samples))


def _first_sign_change(value, count, samples):
    """Where (count,), in 0..1, value(t) first falls below zero, from `samples` steps and bisection; NaN for nowhere."""
    low, high = np.full(count, np.nan), np.full(count, np.nan)
    for k in range(1, samples):
        found = np.isnan(low) & (value(np.full(count, k / samples)) < 0)
        low[found], high[found] = (k - 1) / samples, k / samples
    with np.errstate(invalid="ignore"):
        for _ in range(50):
            middle = (low + high) / 2
            before = value(middle) >= 0
            low, high = np.where(before, middle, low), np.where(before, high, middle)
    return (low + high) / 2
