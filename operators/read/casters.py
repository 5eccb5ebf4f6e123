"""Which objects cast caustics and which only block light, triangle by triangle: by material, and by what was asked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...kernels.casters import Caster
from ...kernels.halfedges import rim_length
from ...kernels.scene import Occluder
from .mesh_arrays import MeshArrays, read_geometry, read_material_index, read_normals, turn_normals
from .shader_nodes import materials_of
from .speculars import MOST_ROUGHNESS, Glass, read_specular

_OPEN = 1e-3  # of a mesh's area: a round hole that is worth a word


@dataclass(frozen=True)
class _Local:
    """A mesh in its own space, shared by its instances, with an index into its materials per triangle; (normals,
    normal_triangles) of those that cast."""

    arrays: MeshArrays
    material_index: np.ndarray
    shading: list


class MeshReader:
    """Reads the meshes of one frame, each mesh and each material once, however many instances there are."""

    def __init__(self):
        self.casters, self.occluders, self.warnings = [], [], []
        self._meshes, self._materials, self._casting = {}, {}, {}

    def add(self, shown, matrix, blocks=True):
        """Add an evaluated object, or an instance, under a world matrix (4,4) to the casters, the occluders or both;
        what does not block light by a shadow may cast all the same: while maps are shown glass has a whole one."""
        name = shown.original.name
        local = self._local(shown)
        positions = local.arrays.positions @ matrix[:3, :3].T + matrix[:3, 3]
        if not np.isfinite(positions).all():
            self.warnings.append(f"Object '{name}' has vertices that are not numbers; it casts no shadow.")
        elif len(local.arrays.triangles):
            self._sort(shown, local, positions, matrix, blocks)

    def _sort(self, shown, local, positions, matrix, blocks):
        """Share the triangles out by what their materials cast: a Glass, a Mirror, or None."""
        name, triangles, casting = shown.original.name, local.arrays.triangles, self._casts(shown, local)
        occluders = self.occluders if blocks else []
        if not any(casting):
            occluders.append(Occluder(name, positions, triangles))
            return
        turn = -1 if np.linalg.det(matrix[:3, :3]) < 0 else 1  # mirrored: wound to agree with their normals again
        normals, index = self._shading(shown, local)
        normals, smooth = turn_normals(normals, matrix), index is triangles
        slots = np.minimum(local.material_index, len(casting) - 1)
        for slot in np.unique(slots):
            own, material = triangles[slots == slot][:, ::turn], casting[slot]
            if material is None:
                occluders.append(Occluder(name, positions, own))
                continue
            shading = own if smooth else index[slots == slot][:, ::turn]
            self.casters.append(Caster(name, positions, own, normals, shading, material))

    def _local(self, shown):
        key = shown.data.as_pointer()
        if key not in self._meshes:
            arrays, index = _read(shown, read_material_index)
            self._meshes[key] = _Local(arrays, index, [])
        return self._meshes[key]

    def _shading(self, shown, local):
        """(normals, normal_triangles) of a mesh in its own space, read when it is first asked for."""
        if not local.shading:
            _, shading = _read(shown, lambda mesh, arrays: read_normals(mesh, np.eye(4), local.arrays))
            local.shading.extend(shading)
        return local.shading

    def _casts(self, shown, local):
        """What each of an object's materials casts."""
        key = shown.data.as_pointer(), shown.original
        if key not in self._casting:
            used = set(np.unique(local.material_index))
            slots = enumerate(materials_of(shown))
            found = [_named(m, shown.original, self._materials) if i in used else None for i, m in slots]
            casting, said = casts(shown.original, found)
            if any(isinstance(material, Glass) for material in casting):
                said += _shape(shown.original.name, local.arrays)
            self._casting[key] = casting
            self.warnings += said
        return self._casting[key]


def _read(shown, reader):
    """(MeshArrays, what a reader makes of it) of an evaluated object in its own space."""
    mesh = shown.to_mesh()
    try:
        arrays = read_geometry(mesh, np.eye(4))
        return arrays, reader(mesh, arrays)
    finally:
        shown.to_mesh_clear()


def _named(material, obj, known):
    """(Specular, name) of a material or None, as an object has it; one for all objects that have it so, in the dict
    `known`."""
    if material is None:
        return None
    own = (float(f"{v:.6g}") for v in (obj.dapple.ior, obj.dapple.abbe))  # Blender keeps them in float32
    key = material.original, *own
    if key not in known:
        found = read_specular(material, *key[1:])
        known[key] = found and (found, material.original.name)
    return known[key]


def caster_names(depsgraph, others):
    """Names, in order, of the mesh objects that cast caustics in an evaluated depsgraph, itself or by an instance;
    others: names of those that do something else."""
    shown = (i.object for i in depsgraph.object_instances if i.object.type == "MESH")
    known, names = {}, {}
    for one in shown:
        obj = one.original
        if obj.name in others or obj.name in names:
            continue
        names[obj.name] = any(casts(obj, [_named(material, obj, known) for material in materials_of(one)])[0])
    return sorted(name for name, cast in names.items() if cast)


def casts(obj, speculars):
    """(what each material casts, Glass, Mirror or None; warnings) of an object with (Specular, name) or None each.

    Automatic casts what is smooth; Casts, or Cycles' own Cast Shadow Caustics, takes rougher ones as smooth.
    """
    wish = _wish(obj)
    casting, said = [], []
    for specular, material in (entry or (None, "") for entry in speculars):
        casting.append(None)
        if specular is None or wish == "NEVER":
            continue
        if specular.wrong:
            said.append(specular.wrong)
        elif specular.roughness > MOST_ROUGHNESS and wish == "AUTO":
            said.append(
                f"'{material}' of object '{obj.name}' is {specular.word} of roughness {specular.roughness:.2g} "
                f"and casts no caustics; set {MOST_ROUGHNESS} or less, or its Caustics to Casts to take it as smooth."
            )
        else:
            casting[-1] = specular.material
            said += specular.warnings
            if specular.roughness > 0:
                said.append(f"Caustics take material '{material}' as smooth, of roughness {specular.roughness:.2g}.")
    if wish == "ALWAYS" and not any(speculars):
        said.append(f"Object '{obj.name}' is to cast caustics, but no material of it refracts or mirrors; it blocks.")
    return casting, said


def _wish(obj):
    """What the artist asked of an object: AUTO, ALWAYS or NEVER."""
    wish = obj.dapple.caustics
    cycles = getattr(obj, "cycles", None)  # Cycles is an add-on, and can be off
    return "ALWAYS" if wish == "AUTO" and getattr(cycles, "is_caustics_caster", False) else wish


def _shape(name, arrays):
    """Warnings on a body of glass that is not closed, or inside out."""
    a, b, c = (arrays.positions[arrays.triangles[:, k]] - arrays.positions.mean(0) for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    if rim_length(arrays.positions, arrays.triangles) ** 2 > 4 * np.pi * _OPEN * area:
        return [
            f"Glass '{name}' is not closed: light that enters it finds no way out as it should. Give it thickness "
            "(a Solidify modifier), or close its holes."
        ]
    if (a * np.cross(b, c)).sum() < 0:
        return [f"Glass '{name}' is inside out: recalculate its normals (in Edit Mode: Mesh > Normals)."]
    return []
