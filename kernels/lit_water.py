"""The water as one light sees it: which triangles it lights, with how much flux, and which may lie in a shadow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .facets import Facets
from .maps.uv_raster import cross2, touching
from .optics import dot, sun_frame
from .scene import Spot, Sun
from .sources import Central, Parallel, in_cone

_SHADOW_GRID = 256  # cells along the longer side of the water, at most
_CLOSE = 1e-3  # of the water's extent: a lamp this near to its plane, or behind it, may cast any shadow
_EVEN = 0.1  # of all weight: a closed body shows as much of one side as of the other, but for normals round its edges
_NEAR = 1e-6  # of the distance to the water: what blocks light nearer to the lamp than that is no object


@dataclass(frozen=True)
class LitWater:
    """Water in the light of one source.

    points (V,3) and shading (N,3), positions and normals in the world, these turned towards the light if the whole
    surface was wound away from it; triangles and normal_triangles (T,3); facets: their Facets; area (T,) [m^2] across
    the light, 0 for triangles whose normals face away; frame (3,3) from the world to that of the light: for a Sun
    `optics.sun_frame`, where light travels along -z, for lamps the world's own; source: Parallel or Central. For lamps
    area is what makes area x met the flux, see `sources.Central`.
    """

    points: np.ndarray
    shading: np.ndarray
    triangles: np.ndarray
    normal_triangles: np.ndarray
    facets: Facets
    area: np.ndarray
    frame: np.ndarray
    source: Parallel | Central

    @cached_property
    def positions(self):
        """Positions (V,3) in the light's frame."""
        return self.points @ self.frame.T

    @cached_property
    def normals(self):
        """Normals (N,3) in the light's frame."""
        return self.shading @ self.frame.T

    def light(self):
        """Flux on the water over the source's power [m^2], from what meets the triangles' centres."""
        centres = self.points[self.triangles].mean(1) if self.source.varies else np.zeros((0, 3))
        light = (self.area * self.source.incident(centres.T)[2]).sum()
        return light if light > 0 else self.area.sum()  # a cone between the centres

    def meets_backs(self):
        """Whether light meets the back of any normal of a triangle that it lights."""
        if not self.source.varies:
            back = self.shading @ self.frame[2] <= 0
            return bool(back.any() and back[self.normal_triangles[self.area > 0]].any())
        for k in range(3):
            at = self.triangles[self.area > 0, k], self.normal_triangles[self.area > 0, k]
            towards = self.source.incident(self.points[at[0]].T)[0]
            if (dot(self.shading[at[1]].T, towards) <= 0).any():
                return True
        return False


def light_water(water, light, facets=None):
    """The LitWater of a Water, with its Facets if they are known, under a Sun, Point or Spot."""
    triangles, normal_triangles = water.triangles, water.normal_triangles
    facets = facets or Facets.of(water.positions, water.normals, triangles, normal_triangles)
    look = _under_sun if isinstance(light, Sun) else _under_lamp
    area, away, frame, source = look(water, light, facets)
    if not away:
        return LitWater(water.positions, water.normals, triangles, normal_triangles, facets, area, frame, source)
    facets = Facets(facets.across, -facets.leaning)
    return LitWater(water.positions, -water.normals, triangles, normal_triangles, facets, area, frame, source)


def _under_sun(water, sun, facets):
    """Area (T,) across the light, whether the surface is wound away from it, the light's frame and source."""
    frame = sun_frame(sun.direction)
    area = np.abs(frame[2] @ facets.across) / 2
    return *_turned(area, frame[2] @ facets.leaning), frame, Parallel(sun)


def _under_lamp(water, lamp, facets):
    """As `_under_sun`."""
    soup = water.positions[water.triangles]
    towards = lamp.position - soup
    volume = np.abs((facets.across.T * towards[:, 0]).sum(1)) / 2
    towards /= np.maximum(np.linalg.norm(towards, axis=2, keepdims=True), np.finfo(float).tiny)
    facing = (water.normals[water.normal_triangles] * towards).sum((1, 2))
    away = np.linalg.norm(soup.mean(1) - lamp.position, axis=1)
    solid_angle = volume / np.maximum(away, np.finfo(float).tiny) ** 3
    total = solid_angle.sum()
    reach = np.cbrt(volume.sum() / total) if total > 0 else 1.0  # so that what is met is 1 in the mean
    area, turned = _turned(volume / reach, facing, solid_angle)
    if isinstance(lamp, Spot):
        area = np.where(in_cone(lamp, soup), area, 0.0)
    return area, turned, np.eye(3), Central(lamp, reach)


def _turned(area, facing, weight=None):
    """Area (T,) without what faces (T,) away from the light, and whether normals are to be turned for that: by the
    majority of `weight`."""
    weight = area if weight is None else weight
    turned = weight @ np.sign(facing) < -_EVEN * weight.sum()
    return np.where(facing < 0 if turned else facing > 0, area, 0.0), turned


def part_of(lit, twins, chosen):
    """The LitWater of the triangles chosen (T,) bool only, and its twins."""
    ids = np.flatnonzero(chosen)
    half = np.full(twins.shape, -1)
    kept = (3 * ids[:, None] + np.arange(3)).ravel()
    half[kept] = np.arange(len(kept))
    points, triangles = _used(lit.points, lit.triangles[ids])
    shading, normal_triangles = _used(lit.shading, lit.normal_triangles[ids])
    if np.array_equal(triangles, normal_triangles):
        normal_triangles = triangles
    facets = Facets(lit.facets.across[:, ids], lit.facets.leaning[:, ids])
    part = LitWater(points, shading, triangles, normal_triangles, facets, lit.area[ids], lit.frame, lit.source)
    return part, np.where(twins[kept] >= 0, half[twins[kept]], -1)


def _used(values, triangles):
    """The values that triangles use, and the triangles into them."""
    used = np.zeros(len(values), bool)
    used[triangles] = True
    return values[used], (np.cumsum(used) - 1)[triangles]


def may_be_shadowed(lit, positions, triangles):
    """Whether (T,) an object could stand between the light and each triangle of the water: False is certain.

    positions (V,3) in world space and triangles (S,3) of everything that blocks light. The objects' heights towards the
    light are drawn, as a maximum, on a grid across it whose cells are as wide as the longest edge of the water, so
    that all that stands over a triangle lies in the cells round its first vertex.
    """
    marked = np.zeros(len(lit.area), bool)
    ids = np.flatnonzero(lit.area)
    if not lit.source.varies:
        up = lit.frame[2, 2]
        if up > 0 and positions[:, 2].max(initial=-np.inf) < lit.points[:, 2].min(initial=np.inf):
            return marked  # nothing is higher than the water, and the light comes from above
        marked[ids] = _overshadowed(lit.positions, lit.triangles[ids], (positions @ lit.frame.T)[triangles])
        return marked
    points, seen = _used(lit.points, lit.triangles[ids])
    points, objects = _from_lamp(points, positions[triangles], lit.source.position)
    marked[ids] = _overshadowed(points, seen, objects) if points is not None else True
    return marked


def _from_lamp(water, objects, lamp):
    """Points water (V,3) and triangles objects (S,3,3) as the lamp sees them; None for water beside it or behind it.

    (x / w, y / w, 1 / w), with w the distance from the lamp's plane, makes its light travel along -z and keeps planes
    and lines; objects that reach behind the lamp are cut at its plane.
    """
    if not len(water):
        return water, objects[:0]
    frame = sun_frame(_unit(water.mean(0) - lamp))
    water, objects = (water - lamp) @ frame.T, (objects - lamp) @ frame.T
    nearest = -water[:, 2].max()
    if nearest < _CLOSE * np.abs(water).max():
        return None, None
    return in_perspective(water), in_perspective(cut_behind(objects, -_NEAR * nearest))


def _unit(v):
    return v / max(np.linalg.norm(v), np.finfo(float).tiny)


def in_perspective(points):
    w = -points[..., 2:]
    return np.concatenate([points[..., :2] / w, 1 / w], -1)


def cut_behind(soup, level):
    """Triangles (S,3,3), cut to what lies below z = level: at most twice as many."""
    below = soup[:, :, 2] < level
    kept = [soup[below.all(1)]]
    for count in (1, 2):
        some = np.flatnonzero(below.sum(1) == count)
        lone = (below[some] == (count == 1)).argmax(1)  # the corner on a side of its own
        a, b, c = (soup[some, (lone + k) % 3] for k in range(3))
        to_b, to_c = (a + ((level - a[:, 2]) / (v - a)[:, 2])[:, None] * (v - a) for v in (b, c))
        parts = [(a, to_b, to_c)] if count == 1 else [(to_b, b, c), (to_b, c, to_c)]
        kept += [np.stack(part, 1) for part in parts]
    return np.concatenate(kept)


def _overshadowed(points, triangles, objects):
    """Whether (n,) one of triangles objects (S,3,3) reaches over each of triangles (n,3) of points (V,3), up being
    +z."""
    if not len(triangles):
        return np.zeros(0, bool)
    corners = np.ascontiguousarray(triangles.T, np.intp)
    x, y, z = (np.take(v, corners) for v in np.ascontiguousarray(points.T))
    edge = np.sqrt(max(((x[k] - x[k - 1]) ** 2 + (y[k] - y[k - 1]) ** 2).max() for k in range(3)))
    low = np.array([x.min(), y.min()])
    width = max(x.max() - low[0], y.max() - low[1])
    cell = max(edge, width / _SHADOW_GRID, np.finfo(float).tiny)
    side = int(np.ceil(width / cell)) + 3
    top = _heights(objects, low - cell, cell, side)
    column, row = (((v - start) / cell + 1).astype(np.int64) for v, start in zip((x[0], y[0]), low, strict=True))
    return top[row, column] > np.minimum(np.minimum(z[0], z[1]), z[2])


def _heights(soup, low, cell, side):
    """Greatest height (side, side) of triangles soup (S,3,3) over each cell of a grid and its eight neighbours."""
    corners = (soup[:, :, :2] - low) / cell
    triangle, flat = touching(corners, side)
    row, column = np.divmod(flat, side)
    v0, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    rise = soup[:, 1:, 2] - soup[:, :1, 2]
    area = cross2(e1, e2)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope_x = (rise[:, 0] * e2[:, 1] - rise[:, 1] * e1[:, 1]) / area
        slope_y = (rise[:, 1] * e1[:, 0] - rise[:, 0] * e2[:, 0]) / area
        middle = slope_x[triangle] * (column + 0.5 - v0[triangle, 0]) + slope_y[triangle] * (
            row + 0.5 - v0[triangle, 1]
        )
        over = soup[triangle, 0, 2] + middle + (np.abs(slope_x) + np.abs(slope_y))[triangle] / 2
    highest = soup[:, :, 2].max(1)[triangle]
    top = np.full(side * side, -np.inf)
    np.maximum.at(top, flat, np.where(over < highest, over, highest))  # highest, too, where it stands on edge
    framed = np.pad(top.reshape(side, side), 1, constant_values=-np.inf)
    shifts = [framed[j : j + side, i : i + side] for j in range(3) for i in range(3)]
    return np.maximum.reduce(shifts)
