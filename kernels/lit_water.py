"""The water as one light sees it: which triangles it lights, with how much flux, and which may lie in a shadow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .maps.uv_raster import cross2, touching
from .optics import sun_frame
from .scene import Spot, Sun
from .sources import Central, Parallel, in_cone

_SHADOW_GRID = 256  # cells along the longer side of the water, at most
_CLOSE = 1e-3  # of the water's extent: a lamp this near to its plane, or behind it, may cast any shadow
_NEAR = 1e-6  # of the distance to the water: what blocks light nearer to the lamp than that is no object


@dataclass(frozen=True)
class LitWater:
    """Water in the light of one source.

    positions (V,3) and normals (N,3), turned towards the light if the whole surface was wound away from it: for a Sun
    in its frame (`optics.sun_frame`), where light travels along -z, for lamps in the world; triangles and
    normal_triangles (T,3); area (T,) [m^2] across the light, 0 for triangles whose normals face away; frame (3,3) from
    the world to that of positions; source: Parallel or Central. For lamps area is what makes area x met the flux, see
    `sources.Central`.
    """

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    normal_triangles: np.ndarray
    area: np.ndarray
    frame: np.ndarray
    source: Parallel | Central

    def light(self):
        """Flux on the water over the source's power [m^2], from what meets the triangles' centres."""
        centres = self.positions[self.triangles].mean(1) @ self.frame if self.source.varies else np.zeros((0, 3))
        light = (self.area * self.source.incident(centres.T)[2]).sum()
        return light if light > 0 else self.area.sum()  # a cone between the centres


def light_water(water, light):
    """The LitWater of a Water under a Sun, Point or Spot."""
    return _under_sun(water, light) if isinstance(light, Sun) else _under_lamp(water, light)


def _under_sun(water, sun):
    frame = sun_frame(sun.direction)
    positions, normals = water.positions @ frame.T, water.normals @ frame.T
    corners = np.take(positions[:, :2], water.triangles, axis=0)
    area = np.abs(cross2(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])) / 2
    facing = np.take(normals[:, 2], water.normal_triangles).sum(1)
    normals, area = _turned(normals, area, facing)
    return LitWater(positions, normals, water.triangles, water.normal_triangles, area, frame, Parallel(sun))


def _under_lamp(water, lamp):
    soup = water.positions[water.triangles]
    towards = lamp.position - soup
    across = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    volume = np.abs((across * towards[:, 0]).sum(1)) / 2
    towards /= np.maximum(np.linalg.norm(towards, axis=2, keepdims=True), np.finfo(float).tiny)
    facing = (water.normals[water.normal_triangles] * towards).sum((1, 2))
    away = np.linalg.norm(soup.mean(1) - lamp.position, axis=1)
    solid_angle = volume / np.maximum(away, np.finfo(float).tiny) ** 3
    total = solid_angle.sum()
    reach = np.cbrt(volume.sum() / total) if total > 0 else 1.0  # so that what is met is 1 in the mean
    normals, area = _turned(water.normals, volume / reach, facing, solid_angle)
    if isinstance(lamp, Spot):
        area = np.where(in_cone(lamp, soup), area, 0.0)
    source = Central(lamp, reach)
    return LitWater(water.positions, normals, water.triangles, water.normal_triangles, area, np.eye(3), source)


def _turned(normals, area, facing, weight=None):
    """Normals towards the light, and area (T,) without what faces (T,) away from it; by the majority of `weight`."""
    if ((area if weight is None else weight) * np.sign(facing)).sum() < 0:
        normals, facing = -normals, -facing
    return normals, np.where(facing > 0, area, 0.0)


def part_of(lit, twins, chosen):
    """The LitWater of the triangles chosen (T,) bool only, and its twins."""
    ids = np.flatnonzero(chosen)
    half = np.full(twins.shape, -1)
    kept = (3 * ids[:, None] + np.arange(3)).ravel()
    half[kept] = np.arange(len(kept))
    positions, triangles = _used(lit.positions, lit.triangles[ids])
    normals, normal_triangles = _used(lit.normals, lit.normal_triangles[ids])
    part = LitWater(positions, normals, triangles, normal_triangles, lit.area[ids], lit.frame, lit.source)
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
        up = lit.frame[:, 2]  # in the light's frame
        if up[2] > 0 and positions[:, 2].max(initial=-np.inf) < (lit.positions @ up).min(initial=np.inf):
            return marked  # nothing is higher than the water, and the light comes from above
        marked[ids] = _overshadowed(lit.positions[lit.triangles[ids]], (positions @ lit.frame.T)[triangles])
        return marked
    water, objects = _from_lamp(lit.positions[lit.triangles[ids]], positions[triangles], lit.source.position)
    marked[ids] = _overshadowed(water, objects) if water is not None else True
    return marked


def _from_lamp(water, objects, lamp):
    """Triangles water (T,3,3) and objects (S,3,3) as the lamp sees them; None for water beside it or behind it.

    (x / w, y / w, 1 / w), with w the distance from the lamp's plane, makes its light travel along -z and keeps planes
    and lines; objects that reach behind the lamp are cut at its plane.
    """
    if not len(water):
        return water, objects[:0]
    frame = sun_frame(_unit(water.mean((0, 1)) - lamp))
    water, objects = (water - lamp) @ frame.T, (objects - lamp) @ frame.T
    nearest = -water[:, :, 2].max()
    if nearest < _CLOSE * np.abs(water).max():
        return None, None
    return _project(water), _project(_cut_behind(objects, -_NEAR * nearest))


def _unit(v):
    return v / max(np.linalg.norm(v), np.finfo(float).tiny)


def _project(soup):
    w = -soup[:, :, 2:]
    return np.concatenate([soup[:, :, :2] / w, 1 / w], 2)


def _cut_behind(soup, level):
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


def _overshadowed(water, objects):
    """Whether (T,) one of triangles objects (S,3,3) reaches over each of water (T,3,3), up being +z."""
    if not len(water):
        return np.zeros(0, bool)
    plan = water[:, :, :2]
    edge = np.sqrt(((plan - np.roll(plan, -1, axis=1)) ** 2).sum(2).max(initial=0))
    low = plan.min((0, 1))
    width = (plan.max((0, 1)) - low).max()
    cell = max(edge, width / _SHADOW_GRID, np.finfo(float).tiny)
    side = int(np.ceil(width / cell)) + 3
    top = _heights(objects, low - cell, cell, side)
    column, row = ((plan[:, 0] - low) / cell + 1).astype(np.int64).T
    return top[row, column] > water[:, :, 2].min(1)


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
