"""Meshes as rays meet them: one soup for what ends light, one for what bends it."""

from __future__ import annotations

import numpy as np

from ..facets import cross
from ..maps.charts import charts
from ..optics import dot
from ..rays import Tracer, soup

_OFF = 2e-6  # of the extent: how far off a surface rays start
_TINY = np.finfo(float).tiny


class Solids:
    """Receivers first, then all that blocks: part (T,), a number for each surface that holds together as one: a chart
    of a receiver, or a mesh; receiving: how many triangles receive."""

    def __init__(self, receivers, others):
        self.positions, self.triangles = soup((*receivers, *others))
        self.tracer = Tracer(self.positions, self.triangles)
        self.receiving = sum(len(r.triangles) for r in receivers)
        parts, count = [np.zeros(0, np.int64)], 0
        for r in receivers:
            parts.append(charts(r.triangles, r.uvs) + count)
            count = parts[-1].max(initial=count - 1) + 1
        sizes = [len(other.triangles) for other in others]
        self.part = np.concatenate([*parts, np.repeat(count + np.arange(len(others)), sizes)])

    def first(self, origin, direction):
        """The first triangle (n,) that rays from origin (3,n) along direction (3,n) meet, MISS for none."""
        return self.tracer.first(origin.T, direction.T)

    def meet(self, triangle, origin, direction):
        """Points (3,n) where rays meet the planes of triangles (n,), and the triangles' unit normals (3,n)."""
        point, facet, _ = _meet(self.positions, self.triangles, triangle, origin, direction)
        return point, facet

    def blocked(self, origin, direction, distance):
        """Whether (n,) something stands within `distance` along rays."""
        return self.tracer.blocked(origin.T, direction.T, distance)


class Shaded:
    """A soup of smooth meshes with normals of their own: meshes have positions, triangles, normals, normal_triangles.

    off [m]: how far off a surface rays start that leave it.
    """

    def __init__(self, meshes):
        self.positions, self.triangles = soup(meshes)
        base = np.cumsum([0, *(len(m.normals) for m in meshes)])
        self._normals = np.concatenate([m.normals for m in meshes])
        self._shading = np.concatenate([m.normal_triangles + b for m, b in zip(meshes, base, strict=False)])
        self.mesh = np.repeat(np.arange(len(meshes)), [len(m.triangles) for m in meshes])
        self.tracer = Tracer(self.positions, self.triangles)
        self.off = _OFF * getattr(self.tracer, "extent", 1.0)

    def first(self, origin, direction):
        """As `Solids.first`."""
        return self.tracer.first(origin.T, direction.T)

    def meet(self, triangle, origin, direction):
        """Points (3,n) where rays meet triangles (n,), and unit normals (3,n), the facets' and the interpolated, on
        the side of the latter."""
        point, facet, weights = _meet(self.positions, self.triangles, triangle, origin, direction)
        corners = self._normals[self._shading[triangle]]
        normal = (corners * weights.T[:, :, None]).sum(1).T
        normal /= np.maximum(np.sqrt(dot(normal, normal)), _TINY)
        return point, np.where(dot(facet, corners.sum(1).T) < 0, -facet, facet), normal


def _meet(positions, triangles, triangle, origin, direction):
    """Points (3,n), unit facet normals by winding (3,n) and barycentric weights (3,n) where rays meet planes."""
    a, b, c = (positions[triangles[triangle, k]].T for k in range(3))
    across = cross(b - a, c - a)
    fall = dot(across, direction)
    point = origin + dot(across, a - origin) / np.where(fall == 0, np.inf, fall) * direction
    squared = np.maximum(dot(across, across), _TINY)
    second = dot(cross(point - a, c - a), across) / squared
    third = dot(cross(b - a, point - a), across) / squared
    weights = np.clip(np.stack([1 - second - third, second, third]), 0, 1)
    return point, across / np.sqrt(squared), weights / weights.sum(0)
