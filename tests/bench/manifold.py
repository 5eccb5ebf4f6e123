"""Comparators: MNEE by Newton's method [1], and specular manifold sampling [2], biased and unbiased, on one water.

Both walk on the water's surface by Newton's method on the specular constraint: at M the half vector h of the ways to
light and receiver is the normal n, so

    c = (h - n)_xy = 0,    h = -(s + eta u) / |s + eta u|,    u = (P - M) / |P - M|.

A step goes in the tangent plane of M's triangle and is projected back to the surface by a ray from P; where that finds
none, the step is halved. MNEE starts where the straight ray to the light passes the water, as the conic walk does. SMS
starts at points drawn evenly over the water: biased, N starts are made and the paths that they find are summed once
each; unbiased, one start finds a path with an unknown probability p, and its light is weighted by the number of further
starts until the same path is found again, which is 1 / p in the mean. Starts may be drawn near the receiver's point,
too: over the disc in which all its paths pass the water.

[1] Hanika, Droske & Fascione 2015, Manifold Next Event Estimation.
[2] Zeltner, Georgiev & Jakob 2020, Specular Manifold Sampling for Rendering High-Frequency Caustics and Glints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dapple.kernels.optics import cosine_refracted
from dapple.kernels.rays import MISS, Tracer, soup
from dapple.kernels.walk.paths import LightPaths

STEPS = 20  # of Newton's method, as in [2]
TRIALS = 256  # Bernoulli trials, at most
_CONVERGED = 1e-6  # |c|
_SAME = 1e-4  # of the mean edge: two ends within that are one path
_LEAST_STEP = 1 / 64


@dataclass
class Ends:
    """Where walks (n,) end: triangle, -1 where none was found, and weights (n,3)."""

    triangle: np.ndarray
    weights: np.ndarray

    def take(self, index):
        return Ends(self.triangle[index], self.weights[index])


class Manifold:
    """Walks on a Scene's water under its first light, for points (K,3) of receivers with normals (K,3)."""

    def __init__(self, scene, points, normals):
        solids = soup((*scene.receivers, *scene.occluders))
        self.paths = LightPaths(scene, scene.lights[0], Tracer(*solids), solids)
        self.eta, self.points, self.normals = scene.eta, points, normals
        lit = self.paths.lit
        self._positions, self._normals = lit.points, lit.shading
        self._triangles, self._shading = lit.triangles, lit.normal_triangles
        self._water = Tracer(lit.points, lit.triangles)
        self._source = lit.source
        soup_ = lit.points[lit.triangles]
        plan = np.cross(soup_[:, 1] - soup_[:, 0], soup_[:, 2] - soup_[:, 0])
        self._cumulated = np.cumsum(np.linalg.norm(plan, axis=1))
        self.edge = float(np.sqrt(self._cumulated[-1] / len(plan)))
        self.walks = 0

    def straight(self):
        """Starts (K,) where the straight rays to the light pass the water."""
        triangle = self.paths.first_water(self.points)
        towards, _, _ = self._source.incident(self.points.T)
        return self._on(triangle, self.points, np.broadcast_to(towards, self.points.T.shape).T)

    def drawn(self, count, rng):
        """Starts (count,) drawn evenly over the water's area."""
        triangle = np.searchsorted(self._cumulated, rng.random(count) * self._cumulated[-1])
        a, b = rng.random((2, count))
        over = a + b > 1
        a, b = np.where(over, 1 - a, a), np.where(over, 1 - b, b)
        return Ends(np.minimum(triangle, len(self._triangles) - 1), np.stack([1 - a - b, a, b], 1))

    def near(self, point, rng):
        """Starts (n,) for points `point` (n,) in 0..K-1, drawn evenly over the discs around where still water would let
        a path pass to them, as wide as its waves throw light aside. The water is level and its light one sun's."""
        at, level = self.points[point], np.median(self._positions[:, 2])
        still = self._slants(np.array([[0.0, 0.0, 1.0]]))
        reach = np.linalg.norm(self._slants(self._normals) - still, axis=1).max()
        depth, turn = level - at[:, 2], 2 * np.pi * rng.random(len(point))
        radius = depth * reach * np.sqrt(rng.random(len(point)))
        start = at - depth[:, None] * np.append(still[0], 0.0)
        start += radius[:, None] * np.stack([np.cos(turn), np.sin(turn), np.zeros(len(point))], 1)
        up = np.broadcast_to([0.0, 0.0, 1.0], start.shape)
        return self._on(self._water.first(start, up), start, up)

    def _slants(self, normals):
        """How far (n,2) light that passes water of `normals` (n,3) moves aside for each metre that it falls."""
        n = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        s, _, _ = self._source.incident(np.zeros((3, 1)))
        cos_i = n @ s[:, 0]
        t = -s[:, 0] / self.eta + (cos_i / self.eta - cosine_refracted(cos_i, self.eta))[:, None] * n
        return -t[:, :2] / t[:, 2:]

    def position(self, ends):
        """Points (n,3) of the water at Ends."""
        corners = self._positions[self._triangles[ends.triangle]]
        return np.einsum("nk,nkx->nx", ends.weights, corners)

    def walk(self, point, start):
        """Ends (n,) of walks for points `point` (n,) in 0..K-1 from Ends `start` (n,)."""
        end = Ends(np.full(len(point), -1), np.zeros((len(point), 3)))
        rest = np.flatnonzero(start.triangle >= 0)
        now, step = start.take(rest), np.ones(len(rest))
        self.walks += len(rest)
        for _ in range(STEPS):
            p = self.points[point[rest]]
            residual, da, db = self._newton(now, p)
            done = residual < _CONVERGED
            end.triangle[rest[done]], end.weights[rest[done]] = now.triangle[done], now.weights[done]
            go = np.flatnonzero(~done)
            rest, now, step, p, da, db = rest[go], now.take(go), step[go], p[go], da[go], db[go]
            if not len(rest):
                break
            e1, e2 = self._edges(now.triangle)
            move = step[:, None] * (da[:, None] * e1 + db[:, None] * e2)
            way = self.position(now) + move - p
            way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
            to = self._on(self._water.first(p, way), p, way)
            found = to.triangle >= 0
            now.triangle[found], now.weights[found] = to.triangle[found], to.weights[found]
            step = np.where(found, np.minimum(2 * step, 1.0), step / 2)
            keep = np.flatnonzero(step >= _LEAST_STEP)
            rest, now, step = rest[keep], now.take(keep), step[keep]
        return end

    def light(self, point, ends):
        """Irradiance (n,) in red that the paths at Ends bring to points `point` (n,), 0 where hidden or none."""
        out = np.zeros(len(point))
        at = np.flatnonzero(ends.triangle >= 0)
        if not len(at):
            return out
        args = ends.triangle[at], ends.weights[at], self.points[point[at]], self.normals[point[at]]
        watts = self.paths.irradiance(*self.paths.factors(*args))[:, 0]
        out[at] = np.where(np.isfinite(watts) & ~self.paths.hidden(*args), watts, 0.0)
        return out

    def _edges(self, triangle):
        v = self._positions[self._triangles[triangle]]
        return v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]

    def _on(self, triangle, origin, direction):
        """Ends where rays from origin (n,3) along direction (n,3) meet triangles (n,), none where that is MISS."""
        hit = triangle != MISS
        v = self._positions[self._triangles[np.where(hit, triangle, 0)]]
        e1, e2, s = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0], origin - v[:, 0]
        q = np.cross(direction, e2)
        det = (e1 * q).sum(1)
        with np.errstate(divide="ignore", invalid="ignore"):
            a = (s * q).sum(1) / det
            b = (direction * np.cross(s, e1)).sum(1) / det
        hit &= np.isfinite(a) & np.isfinite(b)
        a, b = np.where(hit, a, 0.0), np.where(hit, b, 0.0)
        return Ends(np.where(hit, triangle, -1), np.stack([1 - a - b, a, b], 1))

    def _newton(self, ends, p):
        """|c| (n,) and Newton's step (n,), (n,) along the edges of the triangles, at Ends for points p (n,3)."""
        corner_n = self._normals[self._shading[ends.triangle]]
        big_n = np.einsum("nk,nkx->nx", ends.weights, corner_n)
        length = np.linalg.norm(big_n, axis=1, keepdims=True)
        n = big_n / length
        m = self.position(ends)
        w = p - m
        far = np.linalg.norm(w, axis=1, keepdims=True)
        u = w / far
        towards, distance, _ = self._source.incident(m.T)
        s = np.broadcast_to(towards, m.T.shape).T
        big_h = -(s + self.eta * u)
        long = np.linalg.norm(big_h, axis=1, keepdims=True)
        h = big_h / long
        c = (h - n)[:, :2]
        slopes = []
        for k, edge in enumerate(self._edges(ends.triangle)):
            du = -(edge - u * (u * edge).sum(1, keepdims=True)) / far
            ds = 0.0
            if self._source.varies:
                ds = -(edge - s * (s * edge).sum(1, keepdims=True)) / distance[:, None]
            dh = -(ds + self.eta * du)
            dh = (dh - h * (h * dh).sum(1, keepdims=True)) / long
            dn = corner_n[:, k + 1] - corner_n[:, 0]
            dn = (dn - n * (n * dn).sum(1, keepdims=True)) / length
            slopes.append((dh - dn)[:, :2])
        (a, c2), (b, d) = slopes[0].T, slopes[1].T
        det = a * d - b * c2
        det = np.where(np.abs(det) < 1e-300, np.inf, det)
        return np.hypot(*c.T), -(d * c[:, 0] - b * c[:, 1]) / det, -(a * c[:, 1] - c2 * c[:, 0]) / det


def mnee(manifold):
    """Irradiance (K,) in red by MNEE, and whether (K,) it finds a path."""
    point = np.arange(len(manifold.points))
    ends = manifold.walk(point, manifold.straight())
    return manifold.light(point, ends), ends.triangle >= 0


def anywhere(manifold):
    """What draws starts over all of the water, for `sms_biased` and `sms_unbiased`; `Manifold.near` is the other."""
    return lambda point, rng: manifold.drawn(len(point), rng)


def sms_biased(manifold, starts, rng, draw=None):
    """Irradiance (K,) in red by so many starts a point, every path that they find once, and how many (K,) that are."""
    draw = draw or anywhere(manifold)
    count = len(manifold.points)
    light, number = np.zeros(count), np.zeros(count, np.int64)
    known = np.full((starts, count, 3), np.inf)
    point = np.arange(count)
    for k in range(starts):
        ends = manifold.walk(point, draw(point, rng))
        found = ends.triangle >= 0
        place = np.where(found[:, None], manifold.position(Ends(np.maximum(ends.triangle, 0), ends.weights)), np.nan)
        near = np.linalg.norm(known[:k] - place, axis=2) < _SAME * manifold.edge
        new = np.flatnonzero(found & ~near.any(0))
        known[k, new] = place[new]
        light[new] += manifold.light(new, ends.take(new))
        number[new] += 1
    return light, number


def sms_unbiased(manifold, samples, rng, draw=None):
    """Irradiance (K,) in red, the mean of so many samples: the light of the path that a start finds, times the trials
    until it is found again; and the share of samples whose trials were cut off at TRIALS."""
    count, draw = len(manifold.points), draw or anywhere(manifold)
    light, cut = np.zeros(count), 0
    for _ in range(samples):
        point = np.arange(count)
        ends = manifold.walk(point, draw(point, rng))
        rest = np.flatnonzero(ends.triangle >= 0)
        watts = manifold.light(rest, ends.take(rest))
        rest, watts = rest[watts > 0], watts[watts > 0]
        place = manifold.position(ends.take(rest))
        for trial in range(1, TRIALS + 1):
            again = manifold.walk(rest, draw(rest, rng))
            there = manifold.position(Ends(np.maximum(again.triangle, 0), again.weights))
            same = (again.triangle >= 0) & (np.linalg.norm(there - place, axis=1) < _SAME * manifold.edge)
            last = same if trial < TRIALS else np.ones(len(rest), bool)
            cut += np.count_nonzero(last & ~same)
            light[rest[last]] += trial * watts[last]
            rest, watts, place = rest[~last], watts[~last], place[~last]
            if not len(rest):
                break
    return light / samples, cut / (samples * count)
