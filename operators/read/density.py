"""How many texels lie on a metre of a receiver, and how many its map needs for so many."""

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


class Sizes:
    """How many texels the maps of a bake have a side: `resolution`, or where `density` [texels/m] is not 0, what each
    receiver needs for so many, as it was when it was kept; else as it is."""

    def __init__(self, resolution, density=0.0):
        self._resolution, self._density, self._kept = resolution, density, {}

    def keep(self, scene):
        """Keep the sizes of a Scene's receivers, so that one which grows keeps the size of its map."""
        self._kept = dict(zip((receiver.name for receiver in scene.receivers), self.of(scene), strict=True))

    def of(self, scene) -> tuple[int, ...]:
        """The sizes for the receivers of a Scene, in their order."""
        if not self._density:
            return (self._resolution,) * len(scene.receivers)
        return tuple(self._kept.get(receiver.name) or self._of(receiver) for receiver in scene.receivers)

    def _of(self, receiver):
        return size_for(_side(receiver), self._density, self._resolution)


def size_for(side, density, otherwise):
    """The size of a map whose side stands for so many metres; `otherwise` where that is not known."""
    if not side:
        return otherwise
    wanted = math.ceil(min(side * density, MOST_RESOLUTION) / _STEP) * _STEP
    return int(min(max(wanted, LEAST_RESOLUTION), MOST_RESOLUTION))


def _side(receiver):
    """How many metres the side of a Receiver's map stands for, the median over its triangles; None without any area."""
    v, uv = receiver.positions[receiver.triangles], receiver.uvs
    world = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1)
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    flat = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    known = (flat > 0) & np.isfinite(world)
    return float(np.median(np.sqrt(world[known] / flat[known]))) if known.any() else None


def resolution_for(density, receiver_names):
    """The size of the largest map of receivers at so many texels a metre. None where none of them tells its size."""
    objects = [shown for name in receiver_names for shown in shown_by(find_object(name)) if shown.type == "MESH"]
    sides = [side for side in map(side_in_metres, objects) if side]
    return size_for(max(sides), density, None) if sides else None
