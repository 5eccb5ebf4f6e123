"""The water of a frame: every mesh that what was picked shows, as one `kernels.scene.Water`.

What is picked shows its own mesh, or where it has none - an Empty, or geometry nodes that make instances only - the
meshes of its instances. What a water with a mesh of its own shows as instances floats on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...kernels.scene import WATER_IOR, Water
from ..errors import DappleError
from .absorption import read_sigma_a
from .medium import read_eta
from .mesh_arrays import MeshArrays, check_mesh, read_geometry, read_normals

_SLOPE = 1e-3  # of the water: an error in it that moves light by a millimetre per metre of depth


@dataclass(frozen=True)
class _Part:
    """A mesh of the water: its MeshArrays; normals (N,3) and normal_triangles (T,3); eta and sigma_a (3,); what is to
    be said of it."""

    arrays: MeshArrays
    normals: np.ndarray
    normal_triangles: np.ndarray
    eta: float
    sigma_a: np.ndarray
    warnings: list


class Waters:
    """The meshes of one frame that are water; picked: the objects that were picked, in order."""

    def __init__(self, picked):
        self._parts = {obj: [] for obj in picked}
        self.seen = set()

    def take(self, instance, matrix):
        """Whether an instance of the depsgraph, under a world matrix (4,4), is water; if so it is kept."""
        shown = instance.object
        own = shown.original
        owner = instance.parent.original if instance.is_instance and instance.parent else own
        self.seen.update({own, owner} & self._parts.keys())
        if own in self._parts:
            owner = own
        elif owner not in self._parts or _has_faces(instance.parent):
            return False
        if shown.type == "MESH" and len(shown.data.polygons):
            self._parts[owner].append(_read(owner.name, shown, matrix))
        return True

    def joined(self, topology):
        """(Water, eta, sigma_a, warnings) of all of them; raises DappleError for one that was picked and shows none."""
        for obj, parts in self._parts.items():
            if not parts:
                raise DappleError(f"Water '{obj.name}' has no faces after its modifiers; check them, or pick another.")
        parts = [part for parts in self._parts.values() for part in parts]
        if not parts:
            return _no_water(), WATER_IOR, np.zeros(3), []
        name, first = " + ".join(obj.name for obj in self._parts), next(iter(self._parts)).name
        warnings = [said for part in parts for said in part.warnings]
        eta, sigma_a = parts[0].eta, parts[0].sigma_a
        if len({part.eta for part in parts}) > 1:
            warnings.append(f"The water objects differ in IOR; the bake takes {eta:.4g}, that of '{first}'.")
        if any((part.sigma_a != sigma_a).any() for part in parts):
            warnings.append(f"The water objects differ in what they absorb; the bake takes that of '{first}'.")
        return Water(name, *_join(parts, topology)), eta, sigma_a, warnings


def _has_faces(evaluated):
    """Whether an evaluated object has a mesh with faces of its own."""
    return evaluated.type == "MESH" and len(evaluated.data.polygons) > 0


def _read(name, shown, matrix):
    """The _Part of an evaluated object, or instance, that belongs to the water `name`."""
    mesh = shown.to_mesh()
    try:
        arrays = read_geometry(mesh, matrix)
        normals, index = read_normals(mesh, matrix, arrays)
    finally:
        shown.to_mesh_clear()
    check_mesh(f"Water '{name}'", arrays)
    (eta, doubts), (sigma_a, more) = read_eta(shown), read_sigma_a(shown)
    return _Part(arrays, normals, index, eta, sigma_a, [*doubts, *more, *_coarse(name, arrays, matrix)])


def _coarse(name, arrays, matrix):
    """A warning where the water's vertices lie so far from its origin that their rounding shows in its slopes."""
    corners = arrays.positions[arrays.triangles]
    edge = float(np.median(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)))
    far = float(np.abs(arrays.positions - matrix[:3, 3]).max())
    rounding = far * np.finfo(np.float32).eps
    if rounding <= _SLOPE * edge:
        return []
    return [
        f"Water '{name}' has vertices {far:.3g} m from its origin, where Blender rounds them to {rounding:.1g} m: its "
        "waves are coarse. Move its origin to the mesh (Object > Set Origin), or the scene to the world's origin."
    ]


def _join(parts, topology):
    """positions, triangles, normals, normal_triangles and twins of the parts as of one mesh."""
    starts = np.cumsum([0] + [len(part.arrays.positions) for part in parts]).astype(np.int32)
    triangles = np.concatenate([part.arrays.triangles + n for part, n in zip(parts, starts)])
    triangles, twins = topology.settle(triangles)
    smooth = all(part.normal_triangles is part.arrays.triangles for part in parts)
    starts = np.cumsum([0] + [len(part.normals) for part in parts]).astype(np.int32)
    shaded = triangles if smooth else np.concatenate([p.normal_triangles + n for p, n in zip(parts, starts)])
    positions = np.concatenate([part.arrays.positions for part in parts])
    return positions, triangles, np.concatenate([part.normals for part in parts]), shaded, twins


def _no_water():
    """Water without triangles, of a scene in which only other things cast."""
    none = np.zeros((0, 3), np.int32)
    return Water("", np.zeros((0, 3)), none, np.zeros((0, 3)), none, np.zeros(0, np.int32))
