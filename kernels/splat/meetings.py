"""Light that meets the water again: a refracted ray that comes out of a wave, a reflected one that hits the next.

Where all of the water looks up, rays that are steeper than its steepest triangle cannot do it: going down inside the
water they come to it from above only, going up outside from below only, which no light on that side can. Only rays that
are not so steep are cast against the water, and followed: where they meet it, by Snell's law or, where most of the
light is reflected, by reflection. The weaker part is not followed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..facets import Facets, cross, extents
from ..halfedges import AFTER
from ..optics import cosine_refracted, fresnel_transmittance
from ..rays import MISS, Tracer
from .slopes import sheets, slopes_round, squared_slopes, steepness

_MOST = 4  # meetings after the first that are followed
_OVERLAP = 1e-6  # of a cell
_OFF, _ROUNDING = 1e-3, 4e-6  # of the water's edges, and of its extent
_NEEDLE = 4.0  # squared slope of a triangle over its edges', unless they all lie within 30 degrees in plan
_CALM = 0.5  # slope: triangles that are no steeper are not looked at so closely
_LOOKED = 4096  # triangles that the edges' length is taken from, at least
_STEEP = np.sqrt(3)  # slope: triangles that are steeper are looked for one by one


@dataclass
class Followed:
    """Rays after their last meeting with the water: origin and direction (3,k); and, (k,) or one for all, share of the
    light at the first meeting that goes this way; inside, in the water or not; wet [m], the way in it up to there;
    history, 0 for rays that meet it once, else a number below HISTORIES that tells how they went on; trapped, for rays
    that meet it more often than is followed."""

    origin: np.ndarray
    direction: np.ndarray
    share: np.ndarray
    inside: np.ndarray
    wet: np.ndarray
    history: np.ndarray
    trapped: np.ndarray


HISTORIES = 2 ** (_MOST + 1)


def once(origin, direction, inside):
    """The Followed rays that meet the water no second time."""
    return Followed(origin, direction, 1.0, inside, 0.0, 0, False)


class Meetings:
    """Water as rays meet it from within and from without.

    positions (V,3), normals (N,3) that point out of the water, triangles and normal_triangles (T,3), twins (3T,);
    solids: a Tracer over all that ends a ray; eta. slope: of the steepest triangle, inf where one does not look up,
    and no more than twice that of its edges and normals, which is the water's where corners lie in a row in plan;
    steep (T,) bool: triangles that are steep or do not look up; gentle: slope of the steepest of the others.
    """

    def __init__(self, positions, normals, triangles, normal_triangles, twins, solids, eta, facets=None):
        self._positions, self._normals = positions, normals
        self._triangles, self._normal_triangles = triangles, normal_triangles
        self._solids, self._eta = solids, eta
        facets = facets or Facets.of(positions, normals, triangles, normal_triangles)
        across = facets.outward()
        squared = squared_slopes(across)
        at = np.flatnonzero(squared > _CALM**2)
        round_it = slopes_round(positions[triangles[at]], normals[normal_triangles[at]])
        squared[at] = np.minimum(squared[at], _NEEDLE * round_it)
        self.steep = squared > _STEEP**2
        self.slope, self.gentle = (float(np.sqrt(v.max(initial=0))) for v in (squared, squared[~self.steep]))
        self._stacked = np.isinf(self.slope) or sheets(positions, triangles, twins) > 1 + _OVERLAP

    @classmethod
    def of(cls, lit, twins, solids, eta):
        """The Meetings of a LitWater with its twins (3T,)."""
        surface = lit.points, lit.shading, lit.triangles, lit.normal_triangles
        return cls(*surface, twins, solids, eta, lit.facets)

    def possible(self, direction):
        """Whether (k,) rays that leave the water along direction (3,k) may meet it again: False is certain."""
        if np.isinf(self.slope):
            return np.ones(direction.shape[1], bool)
        return np.abs(direction[2]) <= self.slope * np.sqrt(direction[0] ** 2 + direction[1] ** 2)

    def sinks(self, direction):
        """Whether (k,) rays that the water reflects along direction (3,k) go down into it more steeply than it is
        anywhere: interpolated normals send them there, no light goes so."""
        if np.isinf(self.slope):
            return np.zeros(direction.shape[1], bool)
        return direction[2] < -self.slope * np.sqrt(direction[0] ** 2 + direction[1] ** 2)

    def never(self, source):
        """Whether no ray of a source, see `sources.py`, can meet the water again that is refracted into it, nor be in
        the shadow of other water: refracted rays lie between the light's direction and the normal."""
        towards = source.incident(self._positions.T)[0]
        flattest = min(steepness(towards), steepness(self._normals.T))
        return flattest > self.slope and not self._stacked

    def shaded(self, m, towards, distance=np.inf):
        """Whether (k,) other water stands between points m (3,k) of the water and the light, `towards` (3,k) or (3,1)
        them, at `distance`, (k,) or one."""
        towards = np.broadcast_to(towards, m.shape)
        shade = np.full(m.shape[1], True) if self._stacked else self.possible(towards)
        at = np.flatnonzero(shade)
        if len(at):
            start = (m[:, at] + self._off * towards[:, at]).T
            distance = np.broadcast_to(distance, m.shape[1])[at] - self._off
            shade[at] = self._water.blocked(start, towards[:, at].T, distance)
        return shade

    def follow(self, m, direction, inside):
        """The Followed rays that leave points m (3,k) of the water along unit direction (3,k), all inside it or all
        outside."""
        count = m.shape[1]
        rays = Followed(
            m, direction, np.ones(count), np.full(count, inside), *np.zeros((2, count), int), np.zeros(count, bool)
        )
        at = np.flatnonzero(self.possible(direction))
        if len(at):
            rays.origin, rays.direction, rays.wet = m.copy(), direction.copy(), np.zeros(count)
        for meeting in range(_MOST + 1):
            at, triangle, distance = self._next(rays, at)
            if not len(at):
                break
            if meeting == _MOST:
                rays.trapped[at] = True
                break
            self._meet(rays, at, triangle, distance)
            at = at[self.possible(rays.direction[:, at])]
        return rays

    @cached_property
    def _water(self):
        return Tracer(self._positions, self._triangles)

    @cached_property
    def _off(self):
        """How far off [m] the water rays start, so that float32 does not find what they leave."""
        some = self._triangles[:: max(1, len(self._triangles) // _LOOKED)]
        v = self._positions[some]
        edge = np.median(np.sqrt(((v - v[:, AFTER]) ** 2).sum(2).min(1)))
        least, most = extents(self._positions, self._triangles)
        return max(_OFF * float(edge), _ROUNDING * float((most.max(1) - least.min(1)).max()))

    def _next(self, rays, at):
        """Those of the rays `at` that come to the water before anything solid: which, triangle and distance.

        Water that they come to from the side on which they are not - the mesh is no closed surface - is passed.
        """
        start = np.full(len(at), self._off)
        found = []
        for _ in range(_MOST):
            if not len(at):
                break
            origin, direction = rays.origin[:, at], rays.direction[:, at]
            hit = self._water.first((origin + start * direction).T, direction.T)
            met = np.flatnonzero(hit != MISS)
            at, hit, origin, direction = at[met], hit[met], origin[:, met], direction[:, met]
            corners, across, turn = self._facet(hit)
            fall = (across * direction).sum(0)
            distance = ((corners[0] - origin) * across).sum(0) / np.where(fall == 0, np.inf, fall)
            right = (fall * turn > 0) == rays.inside[at]
            found.append((at[right], hit[right], distance[right]))
            at, start = at[~right], np.maximum(distance[~right], start[met][~right]) + self._off
        if not found:
            return at, at, start
        at, hit, distance = (np.concatenate(part) for part in zip(*found, strict=True))
        free = ~self._solids.blocked(rays.origin[:, at].T, rays.direction[:, at].T, distance)
        return at[free], hit[free], distance[free]

    def _facet(self, triangle):
        """Corners (3 of (3,n)) of triangles (n,), vectors (3,n) across them, and 1 or -1 (n,) to turn these out of the
        water."""
        corners = [self._positions[self._triangles[triangle, k]].T for k in range(3)]
        across = cross(corners[1] - corners[0], corners[2] - corners[0])
        return corners, across, _turn(across, self._normals, self._normal_triangles[triangle])

    def _meet(self, rays, at, triangle, distance):
        """Move the rays `at` to their meeting with the water and turn them there."""
        direction, inside = rays.direction[:, at], rays.inside[at]
        point = rays.origin[:, at] + distance * direction
        normal = self._normal(triangle, point)
        along = (normal * direction).sum(0)
        normal *= np.where(along > 0, -1.0, 1.0)  # against the ray
        cos_i = np.abs(along)
        ratio = np.where(inside, self._eta, 1 / self._eta)
        squared = 1 - ratio**2 * (1 - cos_i**2)
        total = squared <= 0
        cos_t = np.sqrt(np.where(total, 0, squared))
        in_air = np.where(inside, cos_t, cos_i)
        passes = fresnel_transmittance(in_air, cosine_refracted(in_air, self._eta), self._eta) * ~total
        through = passes >= 0.5
        rays.wet[at] += distance * inside
        rays.origin[:, at] = point
        bent = ratio * direction + (ratio * cos_i - cos_t) * normal
        rays.direction[:, at] = np.where(through, bent, direction + 2 * cos_i * normal)
        rays.inside[at] = inside ^ through
        rays.share[at] *= np.where(through, passes, 1 - passes)
        rays.history[at] = 2 * np.maximum(rays.history[at], 1) + through

    def _normal(self, triangle, point):
        """Unit normals (3,n), interpolated, at points (3,n) of triangles (n,)."""
        (v0, v1, v2), across, _ = self._facet(triangle)
        squared = (across**2).sum(0)
        b = (cross(point - v0, v2 - v0) * across).sum(0) / squared
        c = (cross(v1 - v0, point - v0) * across).sum(0) / squared
        n0, n1, n2 = (self._normals[self._normal_triangles[triangle, k]].T for k in range(3))
        normal = n0 + b * (n1 - n0) + c * (n2 - n0)
        return normal / np.sqrt((normal**2).sum(0))


def _turn(across, normals, normal_triangles):
    """-1 (n,) where vectors across (3,n) of triangles point to the other side than their shading normals, else 1."""
    along = sum((across * normals[normal_triangles[:, k]].T).sum(0) for k in range(3))
    return np.where(along < 0, -1.0, 1.0)
