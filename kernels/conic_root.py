"""The root inside a triangle: where f vanishes on an arc of the conic between two points of opposite sign.

The triangle is cut, as source [1] of `conic.py` does (3.4.3), by lines through one of its corners that cross the arc
once; along the fan of lines f has one variable, and regula falsi (Illinois) closes in on the zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .conic import AFTER, objective

_ITERATIONS = 60
_CLOSE = 1e-12  # of the arc's parameter, and of f at its ends


@dataclass
class Brackets:
    """Arcs (n,) with a sign change: triangle (n,), apex (n,) corner 0..2 that the fan of lines starts from, weights_in
    and weights_out (n,3) barycentric ends, e (2,n) the sense of f at the first end, p (3,n) the receiver points."""

    triangle: np.ndarray
    apex: np.ndarray
    weights_in: np.ndarray
    weights_out: np.ndarray
    e: np.ndarray
    p: np.ndarray


def apex_between(edge_in, edge_out):
    """Corner whose lines cross the arc between two edges once: the one they share, or the one across a single edge."""
    after = AFTER[edge_in]
    return np.where(edge_in == edge_out, AFTER[after], np.where(edge_out == after, after, edge_in))


def solve_brackets(surface, brackets, eta):
    """Barycentric weights (n,3) of the root on every arc."""
    fan = _Fan(surface, brackets, eta)
    a, b = np.zeros(len(brackets.apex)), np.ones(len(brackets.apex))
    every = np.arange(len(a))
    fa, fb = fan.f(a, every), fan.f(b, every)
    root = np.where(np.abs(fa) < np.abs(fb), a, b)
    scale = np.maximum(np.abs(fa), np.abs(fb)) * _CLOSE
    active = np.flatnonzero((fa < 0) != (fb < 0))
    a, b, fa, fb = a[active], b[active], fa[active], fb[active]
    for _ in range(_ITERATIONS):
        t = (a * fb - b * fa) / (fb - fa)
        f = fan.f(t, active)
        root[active] = t
        crossed = (f < 0) != (fb < 0)
        a, fa = np.where(crossed, b, a), np.where(crossed, fb, fa * 0.5)  # halving makes the end that stays move too
        b, fb = t, f
        going = np.flatnonzero((np.abs(b - a) > _CLOSE) & (np.abs(f) > scale[active]))
        if not len(going):
            break
        active, a, b, fa, fb = active[going], a[going], b[going], fa[going], fb[going]
    return fan.weights(root, every)


class _Fan:
    """The lines from an apex Q to the points of the chord of an arc, and where each meets the arc.

    On the line Q + sigma (X_t - Q), X_t at share t of the chord, g is quadratic in sigma; the arc is at sigma near 1.
    """

    def __init__(self, surface, brackets, eta):
        self.eta, self.p, self.e = eta, brackets.p, brackets.e
        row = np.arange(len(brackets.apex))
        at_apex = np.zeros_like(brackets.weights_in)
        at_apex[row, brackets.apex] = 1
        self._weights = [at_apex, brackets.weights_in - at_apex, brackets.weights_out - at_apex]
        ends = [surface.at(brackets.triangle, w) for w in (at_apex, brackets.weights_in, brackets.weights_out)]
        apex, first, last = (np.concatenate(e) for e in ends)  # (6,n): M and N
        self._apex, self._first, self._last = apex, first - apex, last - apex
        self._rising = np.ones(len(row))
        linear, square, _ = self._form(self._first, row)
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
        ray = (1 - t) * self._first[:, rows] + t * self._last[:, rows]
        linear, square, constant = self._form(ray, rows)
        turn = self._rising[rows]  # the arc is where g rises (or falls) along the line
        root = turn * np.sqrt(np.maximum(linear * linear - 4 * square * constant, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            sigma = np.where(turn * linear >= 0, -2 * constant / (linear + root), (root - linear) / (2 * square))
        return np.where(np.isfinite(sigma), sigma, 1.0), ray

    def f(self, t, rows):
        """f (n,) on lines t of the arcs `rows`."""
        sigma, ray = self._sigma(t, rows)
        point = self._apex[:, rows] + sigma * ray
        return objective(point[:3], point[3:], self.p[:, rows], self.eta, *self.e[:, rows])[0]

    def weights(self, t, rows):
        """Barycentric weights (n,3) of the arc's point on lines t."""
        sigma, _ = self._sigma(t, rows)
        at_apex, first, last = self._weights
        return at_apex + sigma[:, None] * ((1 - t)[:, None] * first + t[:, None] * last)
