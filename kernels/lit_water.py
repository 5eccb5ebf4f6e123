"""The water as one sun sees it: which triangles it lights, with how much flux, and which may lie in a shadow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .maps.uv_raster import cross2, touching
from .optics import sun_frame

_SHADOW_GRID = 256  # cells along the longer side of the water, at most


@dataclass(frozen=True)
class LitWater:
    """Water in the frame of one sun (`optics.sun_frame`): its light travels along -z.

    positions (V,3) and normals (N,3) in that frame, the normals turned towards the sun if the whole surface was wound
    away from it; triangles and normal_triangles (T,3); area (T,) [m^2] across the light, 0 for triangles whose normals
    face away; frame (3,3).
    """

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    normal_triangles: np.ndarray
    area: np.ndarray
    frame: np.ndarray


def light_water(water, sun):
    """The LitWater of a Water under a Sun."""
    frame = sun_frame(sun.direction)
    positions, normals = water.positions @ frame.T, water.normals @ frame.T
    corners = np.take(positions[:, :2], water.triangles, axis=0)
    area = np.abs(cross2(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])) / 2
    facing = np.take(normals[:, 2], water.normal_triangles).sum(1)
    if (area * np.sign(facing)).sum() < 0:
        normals, facing = -normals, -facing
    area = np.where(facing > 0, area, 0.0)
    return LitWater(positions, normals, water.triangles, water.normal_triangles, area, frame)


def part_of(lit, twins, chosen):
    """The LitWater of the triangles chosen (T,) bool only, and its twins."""
    ids = np.flatnonzero(chosen)
    half = np.full(twins.shape, -1)
    kept = (3 * ids[:, None] + np.arange(3)).ravel()
    half[kept] = np.arange(len(kept))
    positions, triangles = _used(lit.positions, lit.triangles[ids])
    normals, normal_triangles = _used(lit.normals, lit.normal_triangles[ids])
    part = LitWater(positions, normals, triangles, normal_triangles, lit.area[ids], lit.frame)
    return part, np.where(twins[kept] >= 0, half[twins[kept]], -1)


def _used(values, triangles):
    """The values that triangles use, and the triangles into them."""
    used = np.zeros(len(values), bool)
    used[triangles] = True
    return values[used], (np.cumsum(used) - 1)[triangles]


def may_be_shadowed(lit, positions, triangles):
    """Whether (T,) an object could stand between the sun and each triangle of the water: False is certain.

    positions (V,3) in world space and triangles (S,3) of everything that blocks light. The objects' heights towards the
    sun are drawn, as a maximum, on a grid across the light whose cells are as wide as the longest edge of the water, so
    that all that stands over a triangle lies in the cells round its first vertex.
    """
    up = lit.frame[:, 2]  # in the light's frame
    if up[2] > 0 and positions[:, 2].max(initial=-np.inf) < (lit.positions @ up).min(initial=np.inf):
        return np.zeros(len(lit.triangles), bool)  # nothing is higher than the water, and the light comes from above
    first = lit.positions[lit.triangles[:, 0]]
    corners = lit.positions[:, :2][lit.triangles]
    edge = np.sqrt(((corners - np.roll(corners, 1, axis=1)) ** 2).sum(2).max(initial=0))
    low = lit.positions[:, :2].min(0)
    width = (lit.positions[:, :2].max(0) - low).max()
    cell = max(edge, width / _SHADOW_GRID, np.finfo(float).tiny)
    side = int(np.ceil(width / cell)) + 3
    top = _heights((positions @ lit.frame.T)[triangles], low - cell, cell, side)
    column, row = ((first[:, :2] - low) / cell + 1).astype(np.int64).T
    lowest = lit.positions[:, 2][lit.triangles].min(1)
    return top[row, column] > lowest


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
