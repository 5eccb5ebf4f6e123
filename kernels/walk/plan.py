"""Refracted rays seen in a plan, where the images of the water's triangles are found.

Depth below the water is measured along an axis that all rays run down: a plane receiver's normal where that is so, the
rays' mean direction otherwise. Points are shifted along the mean direction into the plan, coordinates (u, v); a ray is
then a line u = A + B depth whose drift B is small.

Over a triangle the landing point is nearly quadratic in the barycentric coordinates, so at every depth its image lies
in the hull of a net of six points, the Bezier points: the corners' images, and twice the image of each edge's middle
less the mean of the images of its ends.
"""

from __future__ import annotations

import numpy as np

from ..halfedges import AFTER
from ..optics import cosine_refracted, dot

_LEVEL = 1e-9  # of their extent: how far points of a plane may lie from it
_STEEP = 0.2  # cosine: rays must meet a receiver's plane at least so steeply for it to be the plan


def refract(normals, arriving, eta):
    """Unit directions (3,k) in which light travelling along `arriving` (3,k) or (3,1) leaves normals (3,k), of any
    length."""
    scale = 1 / np.maximum(np.sqrt(dot(normals, normals)), np.finfo(float).tiny)
    cos_i = -dot(arriving, normals) * scale
    return (cos_i / eta - cosine_refracted(cos_i, eta)) * scale * normals + arriving / eta


class Rays:
    """Rays at the water's corners and at the middles of its edges: origin, direction (3,k); lit (3,j), those directions
    where the light meets the front of the normal; corner, middle (T,3), the rays of each triangle, middle i that of
    edge i."""

    def __init__(self, surface, eta):
        half = np.arange(len(surface.over))
        owner = np.where(surface.shared & (surface.over < half), surface.over, half)
        edges = np.flatnonzero(owner == half)
        tail, head = surface.tail[edges], surface.head[edges]
        self.origin, normal = (
            np.concatenate([v, (np.take(v, tail, axis=1) + np.take(v, head, axis=1)) / 2], 1)
            for v in (surface.m, surface.n)
        )
        arriving = surface.arriving(self.origin)
        self.direction = refract(normal, arriving, eta)
        facing = dot(arriving, normal) < 0
        self.lit = self.direction if facing.all() else self.direction[:, facing]
        self.corner = surface.tail.reshape(-1, 3)
        number = np.cumsum(owner == half) - 1 + surface.m.shape[1]
        self.middle = number[owner].reshape(-1, 3)

    def mean(self):
        """Mean direction (3,), unit; that of the light where there is no ray."""
        total = self.lit.sum(1)
        length = np.linalg.norm(total)
        return total / length if length > 0 else np.array([0.0, 0.0, -1.0])


class Plan:
    """The plan for points p (3,n) under Rays: coordinates u, v and depth of both. flat: all points have one depth."""

    def __init__(self, rays, p):
        mean = rays.mean()
        self._centre = p.mean(1) if p.shape[1] else np.zeros(3)
        down, self.flat = _down(p - self._centre[:, None], rays, mean)
        across = np.eye(3)[np.abs(down).argmin()]
        first = np.cross(down, across)
        first /= np.linalg.norm(first)
        # Rows: u, v, sheared along the mean ray, and depth.
        axes = np.stack([first, np.cross(down, first), down])
        axes[:2] -= np.outer(axes[:2] @ mean, down) / (down @ mean)
        self._axes = axes
        self._rays = rays

    def points(self, p):
        """(u, v, depth) (3,n) of points p (3,n)."""
        u, v, depth = self._axes @ (p - self._centre[:, None])
        return u, v, depth

    def lines(self):
        """A and B (2,k) of all rays."""
        u, v, depth = self._axes @ (self._rays.origin - self._centre[:, None])
        du, dv, fall = self._axes @ self._rays.direction
        drift = np.stack([du, dv]) / np.where(fall > 0, fall, np.inf)
        return np.stack([u, v]) - depth * drift, drift


def _down(p, rays, mean):
    """Unit axis (3,) of depth for centred points p (3,n), and whether they all have one depth."""
    normal = np.linalg.eigh(p @ p.T)[1][:, 0]
    normal *= 1.0 if normal @ mean > 0 else -1.0
    steepness = (normal @ rays.lit).min(initial=1)
    if np.abs(normal @ p).max(initial=0) <= _LEVEL * np.abs(p).max(initial=0) and steepness > _STEEP:
        return normal, True
    return mean, False


def net(first, second, third, middles):
    """Bezier points between the corners, three arrays, of a quadratic map with values at the corners first, second,
    third and at the middles of the edges from them."""
    corner = (first, second, third)
    return [2 * middles[k] - (corner[k] + corner[AFTER[k]]) / 2 for k in range(3)]
