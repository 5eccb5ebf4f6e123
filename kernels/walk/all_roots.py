"""Every refracted path to a point: Newton's method in all triangles whose image holds it.

With w = P - M and h = eta w / |w| - d, Snell's law says that h lies along the normal N. In a frame where no N_z
vanishes that is

    h_x N_z - h_z N_x = 0,    h_y N_z - h_z N_y = 0.

Under a sun, with the light along -z, the two are G of `conic.objective`; of a lamp at L, d = (M - L) / |M - L|. They
are smooth and nearly linear over a triangle: three or four steps do. Where a triangle's image turns over it may hold
two paths: there the method starts from several points, far enough apart to end at each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..optics import dot
from .candidates import candidates

_STEPS, _STEPS_FOLDED = 12, 40  # of Newton's method; more where the image turns over
_BATCH = 1 << 14  # pairs at once: what a step touches stays in the second-level cache
_CONVERGED, _CONVERGED_FOLDED = 1e-5, 1e-7  # barycentric: the last step of a method that squares its error
_AWAY = 1.0  # barycentric: so far outside its triangle a path of a smooth image does not come back
_INSIDE = 1e-9  # barycentric: rounding of a path on an edge
_SAME, _SAME_ON_EDGE = 1e-6, 1e-8  # of a triangle's edge; in one triangle, and in two that may fold along theirs
_RESIDUAL = 1e-7  # of Snell's law
_TINY = np.finfo(float).tiny
_SEVERAL = np.array([[1 / 3, 1 / 3], [0.05, 0.05], [0.9, 0.05], [0.05, 0.9], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])


@dataclass
class Roots:
    """Paths (n,): point that each leads to, triangle, weights (n,3) barycentric."""

    point: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray

    def take(self, index):
        return Roots(*(np.take(a, index, axis=0) for a in vars(self).values()))

    @classmethod
    def none(cls):
        return cls(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3)))

    @classmethod
    def concatenated(cls, parts):
        return cls(*(np.concatenate(a) for a in zip(*(vars(part).values() for part in parts), strict=True)))


def find_roots(surface, grid, triangles, p, eta, thorough=False):
    """All Roots of receiver points p (3,K), those of a `candidates.Grid`, in triangles (m,) of a Surface, one point's
    together, in the frame of the light; thorough: from several starts in every triangle near them."""
    found, suspect = [Roots.none()], [np.zeros(0, bool)]
    for triangle, point, a, b, several in _batches(candidates(grid, triangles, thorough)):
        at, weights = _solve(surface, triangle, p[:, point], a, b, eta, several)
        found.append(Roots(point[at], triangle[at], weights))
        suspect.append((_least(weights) < _SAME_ON_EDGE) | several)
    roots, suspect = Roots.concatenated(found), np.concatenate(suspect)
    order = np.lexsort((roots.triangle, roots.point))
    roots, suspect = roots.take(order), suspect[order]
    return roots.take(np.flatnonzero(~_repeated(surface, roots, suspect)))


def _batches(blocks):
    """Triangles, points, start a, b, of the Pairs in `blocks`, in batches: False, those of smooth images, or True,
    those of images that turn over, from several points each."""
    waiting = {False: [], True: []}
    for pairs in blocks:
        for several, parts in waiting.items():
            at = np.flatnonzero(pairs.folded == several)
            if len(at):
                parts.append(_starts(pairs, at, several))
            if sum(len(part[0]) for part in parts) > _BATCH:
                yield *(np.concatenate(c) for c in zip(*parts, strict=True)), several
                parts.clear()
    for several, parts in waiting.items():
        if parts:
            yield *(np.concatenate(c) for c in zip(*parts, strict=True)), several


def _starts(pairs, at, several):
    """Triangles, points, start a, b of some of Pairs."""
    triangle, point = pairs.triangle[at], pairs.point[at]
    if not several:
        return triangle, point, np.clip(pairs.a[at], 0, 1), np.clip(pairs.b[at], 0, 1)
    a, b = np.tile(_SEVERAL, (len(at), 1)).T
    return np.repeat(triangle, len(_SEVERAL)), np.repeat(point, len(_SEVERAL)), a, b


class _Snell:
    """Both equations and their derivatives on triangles (n,) for points p (3,n)."""

    def __init__(self, surface, triangle, p, eta):
        first, second, third = surface.corner_records(triangle).T
        m0, n0 = ([np.take(c, first) for c in table] for table in (surface.m, surface.n))
        self.e1, self.e2 = ([np.take(c, k) - o for c, o in zip(surface.m, m0, strict=True)] for k in (second, third))
        self.n1, self.n2 = ([np.take(c, k) - o for c, o in zip(surface.n, n0, strict=True)] for k in (second, third))
        self.n0, self.q, self.eta = n0, [p[i] - m0[i] for i in range(3)], eta
        self.v0 = None if surface.lamp is None else [m0[i] - surface.lamp[i] for i in range(3)]

    def take(self, index):
        other = object.__new__(_Snell)
        other.eta, other.v0 = self.eta, None
        for name in ("e1", "e2", "n0", "n1", "n2", "q", "v0"):
            if getattr(self, name) is not None:
                setattr(other, name, [np.take(c, index) for c in getattr(self, name)])
        return other

    def step(self, a, b):
        """Newton's step (da, db) from (a, b)."""
        n1, n2 = self.n1, self.n2
        n = [o + a * i + b * j for o, i, j in zip(self.n0, n1, n2, strict=True)]
        h, h1, h2 = self._half(a, b)
        kx, ky = (h[k] * n[2] - h[2] * n[k] for k in (0, 1))
        x1, x2 = (h[0] * k[2] + g[0] * n[2] - g[2] * n[0] - h[2] * k[0] for k, g in ((n1, h1), (n2, h2)))
        y1, y2 = (h[1] * k[2] + g[1] * n[2] - g[2] * n[1] - h[2] * k[1] for k, g in ((n1, h1), (n2, h2)))
        det = x1 * y2 - x2 * y1
        scale = 1 / np.where(det == 0, _TINY, det)
        return (x2 * ky - y2 * kx) * scale, (y1 * kx - x1 * ky) * scale

    def _half(self, a, b):
        """h (3), times |w|, and times |M - L| for a lamp, and its derivatives (3) along a and b."""
        e1, e2, eta = self.e1, self.e2, self.eta
        w = [q - a * i - b * j for q, i, j in zip(self.q, e1, e2, strict=True)]
        length, (l1, l2) = _length(w, e1, e2)
        if self.v0 is None:
            h = eta * w[0], eta * w[1], eta * w[2] + length
            return h, *((-eta * e[0], -eta * e[1], -eta * e[2] - g) for e, g in ((e1, l1), (e2, l2)))
        v = [o + a * i + b * j for o, i, j in zip(self.v0, e1, e2, strict=True)]
        away, (r1, r2) = _length(v, e1, e2)
        h = [eta * away * w[k] - length * v[k] for k in range(3)]
        return h, *(
            [eta * (r * w[k] - away * e[k]) + g * v[k] - length * e[k] for k in range(3)]
            for e, g, r in ((e1, l1, r1), (e2, l2, r2))
        )


def _length(v, e1, e2):
    """Length (n,) of v (3), and its derivatives as v moves along e1 and e2 (3)."""
    length = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    over = 1 / np.maximum(length, _TINY)
    return length, [(v[0] * e[0] + v[1] * e[1] + v[2] * e[2]) * over for e in (e1, e2)]


def _solve(surface, triangle, p, a, b, eta, several):
    """Newton's method on triangles (n,) for points p (3,n) from (a, b): indices of those that end on a path inside, and
    its weights."""
    snell = _Snell(surface, triangle, p, eta)
    result = np.full((2, len(a)), np.nan)
    active = np.arange(len(a))
    steps, converged = (_STEPS_FOLDED, _CONVERGED_FOLDED) if several else (_STEPS, _CONVERGED)
    for _ in range(steps):
        da, db = snell.step(a, b)
        longest = np.maximum(np.abs(da), np.abs(db))
        if several:
            shrink = np.minimum(1, 0.5 / np.maximum(longest, 1e-300))
            da, db = da * shrink, db * shrink
        a, b = a + da, b + db
        done = longest < converged
        result[:, active[done]] = a[done], b[done]
        going = ~done & (np.minimum(np.minimum(a, b), 1 - a - b) > -_AWAY)
        if going.all():
            continue
        going = np.flatnonzero(going)
        if not len(going):
            break
        active, a, b, snell = active[going], a[going], b[going], snell.take(going)
    weights = np.stack([1 - result[0] - result[1], *result], 1)
    at = np.flatnonzero(_least(weights) >= -_INSIDE)  # not so where there is none, NaN
    m, n = surface.at(triangle[at], weights[at])
    good = _refracted(surface, np.stack(m), np.stack(n), p[:, at], eta)
    return at[good], weights[at[good]]


def _least(weights):
    """The least (n,) of weights (n,3)."""
    return np.minimum(np.minimum(weights[:, 0], weights[:, 1]), weights[:, 2])


def _refracted(surface, m, n, p, eta):
    """Whether (n,) light that meets the front of normals n (3,n) at m (3,n) is bent to p (3,n)."""
    d, u = surface.arriving(m), p - m
    u /= np.maximum(np.sqrt(dot(u, u)), _TINY)
    normal = n / np.maximum(np.sqrt(dot(n, n)), _TINY)
    hx, hy, hz = eta * u - d
    nx, ny, nz = normal
    residual = np.maximum(np.abs(hy * nz - hz * ny), np.abs(hz * nx - hx * nz))
    residual = np.maximum(residual, np.abs(hx * ny - hy * nx))
    return (residual < _RESIDUAL) & (dot(d, normal) < 0) & (dot(u, normal) < 0)


def _repeated(surface, roots, suspect):
    """Whether (n,) a root, of Roots sorted by points, is an earlier one of its point again."""
    at = np.flatnonzero(suspect)
    again = np.zeros(len(suspect), bool)
    if not len(at):
        return again
    point, triangle = roots.point[at], roots.triangle[at]
    m = np.stack(surface.at(triangle, roots.weights[at])[0])
    corner = surface.corners(triangle)[0]
    size = np.abs(corner[1] - corner[0]).max(0) + np.abs(corner[2] - corner[0]).max(0)
    for lag in range(1, int(np.bincount(point).max())):
        same = point[lag:] == point[:-lag]
        if not same.any():
            break
        near = np.where(triangle[lag:] == triangle[:-lag], _SAME, _SAME_ON_EDGE)
        same &= np.abs(m[:, lag:] - m[:, :-lag]).max(0) < near * size[lag:]
        again[at[lag:][same]] = True
    return again
