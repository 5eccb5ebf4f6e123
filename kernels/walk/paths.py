"""All paths of one light through the water to points on the receivers: found, proven complete, and seen or hidden."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..lit_water import light_water, may_be_shadowed
from ..optics import dot, sun_frame
from ..rays import Tracer
from .all_roots import Roots, find_roots
from .candidates import Grid
from .certificate import missing, whole_triangles
from .lit_surface import Surface
from .path_irradiance import path_irradiance
from .plan import Rays

_BLOCK = 1 << 13  # paths at once: what they touch stays in the second-level cache


@dataclass
class Paths:
    """Paths (n,): point that each leads to, triangle, visible (n,) bool, passed, density and length as of
    `path_irradiance`; and missing (K,) bool: it is proven of a point that paths to it are missing, or counted twice."""

    point: np.ndarray
    triangle: np.ndarray
    visible: np.ndarray
    passed: np.ndarray
    density: np.ndarray
    length: np.ndarray
    missing: np.ndarray


class LightPaths:
    """The paths of one light of a Scene; objects: a Tracer of all that blocks it, `solids` its positions and triangles;
    without: `Settings.without`.

    triangles: those that the light meets; whole: of them, those whose normals face it everywhere; in_shadow (T,) bool:
    something may stand between the light and a triangle.
    """

    def __init__(self, scene, light, objects, solids, without=()):
        lit = light_water(scene.water, light)
        self.light, self.lit, self.fresnel = light, _upright(lit), "fresnel" not in without
        shade = np.zeros(len(lit.area), bool) if "occlusion" in without else may_be_shadowed(lit, *solids)
        self.in_shadow = shade
        self.surface = Surface(self.lit, scene.water.twins)
        self.eta, self._sigma_a, self._objects = scene.eta, np.asarray(scene.sigma_a), objects
        self.triangles = np.flatnonzero(self.lit.area)
        self.whole = whole_triangles(self.surface, self.triangles)

    def to(self, points, normals):
        """The Paths to points (K,3) of one receiver, with normals (K,3)."""
        roots, factors, wrong = self._search(points, normals, False)
        if wrong.any():
            again = np.flatnonzero(wrong)
            keep = np.flatnonzero(~wrong[roots.point])
            more, more_factors, wrong[again] = self._search(points[again], normals[again], True)
            more.point = again[more.point]
            roots = Roots.concatenated([roots.take(keep), more])
            factors = np.concatenate([factors[:, keep], more_factors], 1)
        passed, density, length = factors
        visible = ~self.hidden(roots.triangle, roots.weights, points[roots.point], normals[roots.point])
        return Paths(roots.point, roots.triangle, visible, passed, np.abs(density), length, wrong)

    def first_water(self, points):
        """Triangle (n,) of the water that the straight ray from points (n,3) to the light meets first, -1 for none."""
        water = Tracer(self.lit.points, self.lit.triangles)
        return water.first(points, self._towards(points)[0])

    @cached_property
    def _rays(self):
        return Rays(self.surface, self.eta)

    def factors(self, triangle, weights, points, normals):
        """`path_irradiance` of paths (n,) to points (n,3) of the world with normals (n,3)."""
        frame, found = self.lit.frame, np.empty((3, len(triangle)))
        for start in range(0, len(triangle), _BLOCK):
            block = slice(start, start + _BLOCK)
            p, normal = frame @ points[block].T, frame @ normals[block].T
            found[:, block] = path_irradiance(
                self.surface, triangle[block], weights[block], p, normal, self.eta, self.fresnel
            )
        return found

    def irradiance(self, passed, density, length):
        """Irradiance (n,3) [W/m^2] that paths with these factors bring."""
        return np.abs(density)[:, None] * self.arriving(passed, length)

    def arriving(self, passed, length):
        """Watts (n,3) that arrive of each m^2 across the light, after absorption along the paths."""
        watts = passed[:, None] * self.lit.source.power
        return watts * np.exp(-length[:, None] * self._sigma_a) if self._sigma_a.any() else watts

    def hidden(self, triangle, weights, points, normals):
        """Whether (n,) an object stands between the light and M, or between M and points (n,3), their own surface with
        normals (n,3) too: light that comes to its back lights it not."""
        m = self.lit.frame.T @ self.surface.at(triangle, weights)[0]
        ray = points.T - m
        length = np.sqrt(dot(ray, ray))
        ray /= np.maximum(length, np.finfo(float).tiny)
        hidden = (dot(ray, normals.T) >= 0) | self._objects.blocked(m.T, ray.T, length)
        shade = np.flatnonzero(self.in_shadow[triangle] & ~hidden)
        hidden[shade] = self._objects.blocked(m.T[shade], *self._towards(m.T[shade]))
        return hidden

    def _towards(self, points):
        """Unit directions (n,3) from points (n,3) to the light, and distances to it."""
        towards, distance, _ = self.lit.source.incident(points.T)
        return np.broadcast_to(towards.T, points.shape), distance

    def grid(self, points):
        """The `candidates.Grid` of points (n,3)."""
        return Grid(self._rays, self.lit.frame @ points.T)

    def _search(self, points, normals, thorough):
        """Roots of points (K,3) with normals (K,3), their `factors`, and whether (K,) some are missing."""
        if not len(self.triangles):
            return Roots.none(), np.zeros((3, 0)), np.zeros(len(points), bool)
        p, grid = self.lit.frame @ points.T, self.grid(points)
        roots = find_roots(self.surface, grid, self.triangles, p, self.eta, thorough)
        factors = self.factors(roots.triangle, roots.weights, points[roots.point], normals[roots.point])
        return roots, factors, missing(self.surface, grid, self.whole, roots, np.sign(factors[1]), len(points))


def _upright(lit):
    """A LitWater, if of a lamp in a frame whose z is the mean normal of what it lights; under a sun z points to it."""
    if not lit.source.varies:
        return lit
    normal = lit.facets.leaning @ lit.area
    length = np.linalg.norm(normal)
    if length == 0:
        return lit
    frame = sun_frame(-normal / length)
    return replace(lit, frame=frame)
