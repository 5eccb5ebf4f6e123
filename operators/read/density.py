"""How many texels lie on a metre of a receiver, and how many a map needs for so many."""

from __future__ import annotations

import math

import numpy as np

from ..bake.remarks import LEAST_RESOLUTION, MOST_RESOLUTION
from .find import find_object, shown_by
from .mesh_arrays import lightmap_layer

_SAMPLE = 200  # faces that are looked at: panels are drawn many times a second
_STEP = 16  # texels: a resolution is a multiple of it


def side_in_metres(obj):
    """How many metres of a mesh object the side of its map stands for, the median over its faces; None where it has no
    UV map of its own, or no area in it."""
    mesh, matrix = obj.data, np.array(obj.matrix_world)[:3, :3]
    layer = mesh.uv_layers.get(lightmap_layer(mesh) or " ")
    if layer is None:
        return None
    found = []
    for k in range(0, len(mesh.polygons), max(1, len(mesh.polygons) // _SAMPLE)):
        face = mesh.polygons[k]
        corners = np.array([mesh.vertices[v].co for v in face.vertices]) @ matrix.T
        uvs = np.array([layer.uv[loop].vector for loop in face.loop_indices])
        flat, world = _area(np.column_stack([uvs, np.zeros(len(uvs))])), _area(corners)
        if flat > 0 and math.isfinite(world / flat):
            found.append(math.sqrt(world / flat))
    return float(np.median(found)) if found else None


def _area(corners):
    """Area of a polygon of corners (n,3)."""
    return np.linalg.norm(np.cross(corners, np.roll(corners, -1, axis=0)).sum(0)) / 2


def resolution_for(texels_per_metre, receiver_names):
    """The resolution at which the maps of all receivers have so many texels a metre at least: that of the largest
    need, for the maps of a bake have one resolution. None where no receiver tells its size."""
    objects = [shown for name in receiver_names for shown in shown_by(find_object(name)) if shown.type == "MESH"]
    sides = [side for side in map(side_in_metres, objects) if side]
    if not sides:
        return None
    wanted = math.ceil(max(sides) * texels_per_metre / _STEP) * _STEP
    return int(min(max(wanted, LEAST_RESOLUTION), MOST_RESOLUTION))
