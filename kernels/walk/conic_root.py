"""The root inside a triangle: where f vanishes on an arc of the conic between two points of opposite sign.

The triangle is cut, as source [1] of `conic.py` does (3.4.3), by lines through a point that cross the arc once; along
the fan of lines f has one variable, and regula falsi (Illinois) closes in on the zero. For an arc between two edges the
point is the corner that they share; for one that comes back to its edge it is the middle of its chord.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import AFTER
from .conic import objective

_ITERATIONS = 60
_CLOSE = 1e-12  # of the arc's parameter, and of f at its ends


@dataclass
class Brackets:
    """Arcs (n,) with a change of sign: triangle (n,), barycentric (n,3) apex, turn, weights_in, weights_out, see `fan`;
    p (3,n) the receiver points; sense of `objective`."""

    triangle: np.ndarray
    apex: np.ndarray
    turn: np.ndarray
    weights_in: np.ndarray
    weights_out: np.ndarray
    p: np.ndarray
    sense: float


def fan(edge_in, weights_in, edge_out, weights_out):
    """Point (n,3) whose lines cross the arc between crossings of two edges once, and the direction (n,3), barycentric,
    that the lines pass half way if they turn by 180 degrees, else 0."""
    after = AFTER[edge_in]
    same = edge_in == edge_out
    corner = np.eye(3)[np.where(same, AFTER[after], np.where(edge_out == after, after, edge_in))]
    middle = (weights_in + weights_out) / 2
    same = same[:, None]
    return np.where(same, middle, corner), np.where(same, corner - middle, 0.0)


def solve_brackets(surface, brackets, eta):
    """Barycentric weights (n,3) of the root on every arc."""
    lines = _Fan(surface, brackets, eta)
    a, b = np.zeros(len(brackets.triangle)), np.ones(len(brackets.triangle))
    every = np.arange(len(a))
    fa, fb = lines.f(a, every), lines.f(b, every)
    root = np.where(np.abs(fa) < np.abs(fb), a, b)
    scale = np.maximum(np.abs(fa), np.abs(fb)) * _CLOSE
    active = np.flatnonzero((fa < 0) != (fb < 0))
    a, b, fa, fb = a[active], b[active], fa[active], fb[active]
    for _ in range(_ITERATIONS):
        t = (a * fb - b * fa) / (fb - fa)
        f = lines.f(t, active)
        root[active] = t
        crossed = (f < 0) != (fb < 0)
        a, fa = np.where(crossed, b, a), np.where(crossed, fb, fa * 0.5)  # halving makes the end that stays move too
        b, fb = t, f
        going = np.flatnonzero((np.abs(b - a) > _CLOSE) & (np.abs(f) > scale[active]))
        if not len(going):
            break
        active, a, b, fa, fb = active[going], a[going], b[going], fa[going], fb[going]
    return lines.weights(root, every)


class _Fan:
    """The lines from an apex Q to the points of the chord of an arc, and where each meets the arc.

    On the line Q + sigma (X_t - Q), X_t at share t of the chord, g is quadratic in sigma; the arc is at sigma near 1.
    """

    def __init__(self, surface, brackets, eta):
        self.eta, self.p, self.sense = eta, brackets.p, brackets.sense
        b = brackets
        self._weights = b.apex, b.weights_in - b.apex, b.weights_out - b.apex, b.turn
        # M and N are linear in the weights, so one matrix (6,3) per triangle turns weights into both.
        self._apex, self._first, self._last, self._turn = (
            np.concatenate(surface.at(b.triangle, weights)) for weights in self._weights
        )
        rows = np.arange(len(b.triangle))
        self._rising = np.ones(len(rows))
        linear, square, _ = self._form(self._first, rows)
        self._rising = np.where(linear + 2 * square < 0, -1.0, 1.0)

    def _form(self, ray, rows):
        """Coefficients of g along rays (6,n) from the apex: linear, quadratic, constant."""
        q, p = self._apex[:, rows], self.p[:, rows]
        mx, my = q[0] - p[0], q[1] - p[1]
        constant = q[3] * my - q[4] * mx
        linear = q[3] * ray[1] - q[4] * ray[0] + ray[3] * my - ray[4] * mx
        return linear, ray[3] * ray[1] - ray[4] * ray[0], constant

    def _sigma(self, t, rows):
        """sigma (n,) of the arc on line t, and the line (6,n)."""
        ray = (1 - t) * self._first[:, rows] + t * self._last[:, rows] + 4 * t * (1 - t) * self._turn[:, rows]
        linear, square, constant = self._form(ray, rows)
        rising = self._rising[rows]  # the arc is where g rises (or falls) along the line
        root = rising * np.sqrt(np.maximum(linear * linear - 4 * square * constant, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = np.where(rising * linear >= 0, -2 * constant / (linear + root), (root - linear) / (2 * square))
        return np.where(np.isfinite(sigma), sigma, 1.0), ray

    def f(self, t, rows):
        """f (n,) on lines t of the arcs `rows`."""
        sigma, ray = self._sigma(t, rows)
        point = self._apex[:, rows] + sigma * ray
        return objective(point[:3], point[3:], self.p[:, rows], self.eta, self.sense)

    def weights(self, t, rows):
        """Barycentric weights (n,3) of the arc's point on lines t."""
        sigma, _ = self._sigma(t, rows)
        apex, first, last, turn = self._weights
        t = t[:, None]
        return apex + sigma[:, None] * ((1 - t) * first + t * last + 4 * t * (1 - t) * turn)
