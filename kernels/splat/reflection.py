"""Which of the water may send reflected light to what stands above it, so that only that is followed.

Reflected rays rise, and steeply so over water that is not steep. What they can meet, the parts of receivers above the
lowest water and water that is steep, is drawn on a grid over the water's plan: each of its triangles as the rectangle
of all points from which a ray, within the range of the directions that there are, can come to it.
"""

from __future__ import annotations

import numpy as np

from ..facets import extents

_CELLS = 128  # along each side of the grid
_LEVEL = 0.1  # rise of a unit ray; those that rise less, or less than the water, are followed without a look at it


def may_reflect_onto(lit, receivers, meetings):
    """Whether (T,) light that a LitWater's triangles reflect could reach a Receiver or first other water, of which
    there are Meetings: False is certain, as far as the directions inside a triangle lie between those at its
    corners."""
    lights = lit.area > 0
    if not lights.any():
        return lights
    at = slice(None) if lights.all() else lights
    triangles, of = lit.triangles[at], lit.normal_triangles[at]
    lowest = np.take(lit.points[:, 2], triangles).min()
    solid = [lit.points[lit.triangles[meetings.steep]], *(r.positions[r.triangles] for r in receivers)]
    solid = np.concatenate([np.zeros((0, 3, 3)), *(s[s[:, :, 2].max(1) > lowest] for s in solid)])
    ray, of = _rays(lit, triangles, of)
    level = meetings.gentle / np.hypot(1, meetings.gentle)
    flat = ray[:, 2] < (max(_LEVEL, level) if len(solid) else level)
    near = flat[of].any(1) if flat.any() else np.zeros(len(of), bool)
    if len(solid) and not near.all():
        ray = ray[np.unique(of[~near])]
        near |= _under(lit.points, triangles, solid, ray[:, :2] / ray[:, 2:], lowest)
    lights[lights] = near
    return lights


def _rays(lit, triangles, normal_triangles):
    """Directions (k,3) of the light that triangles (n,3) reflect, and which of them (n,3) at their corners."""
    if not lit.source.varies:
        return reflected(lit.shading, lit.frame[2]), normal_triangles
    towards, _, _ = lit.source.incident(lit.points[triangles.ravel()].T)
    of = np.arange(triangles.size).reshape(triangles.shape)
    return reflected(lit.shading[normal_triangles.ravel()], towards.T), of


def reflected(normals, towards):
    """Unit directions (n,3) of light from unit directions `towards` (n,3) or (3,) after reflection at normals (n,3)."""
    along = np.maximum(np.einsum("...i,...i", normals, towards), 0)
    along /= np.maximum(np.einsum("ni,ni->n", normals, normals), np.finfo(float).tiny)
    return 2 * along[:, None] * normals - towards


def _under(points, triangles, solid, drift, lowest):
    """Whether (n,) triangles (n,3) of points (V,3) may meet triangles solid (S,3,3) along rays that drift by drift
    (k,2) per metre of rise, from no deeper than `lowest`."""
    least, most = extents(points[:, :2], triangles)
    low, high = least.min(1), most.max(1)
    edge = (most - least).max(1)
    cell = np.maximum((high - low) / _CELLS, np.finfo(float).tiny)
    height = solid[:, :, 2].max(1)[:, None] - lowest
    first = solid[:, :, :2].min(1) - np.maximum(height * drift.max(0), 0) - edge
    last = solid[:, :, :2].max(1) - np.minimum(height * drift.min(0), 0) + edge
    first = _cell(first, low, cell, _CELLS + 1)
    last = _cell(last + cell, low, cell, _CELLS + 1)
    count = np.zeros((_CELLS + 2, _CELLS + 2), np.int64)
    for column, row, sign in ((first, first, 1), (last, last, 1), (first, last, -1), (last, first, -1)):
        np.add.at(count, (column[:, 0], row[:, 1]), sign)
    count = count.cumsum(0).cumsum(1)
    column, row = _cell(points[:, :2], low, cell, _CELLS).T
    return np.take((count > 0)[column, row], triangles[:, 0])


def _cell(points, low, cell, most):
    """The cells (n,2) that points (n,2) lie in, from 0 to `most`."""
    return np.clip((points - low) / cell, 0, most).astype(np.int64)
