"""One frame of a Blender scene as a `kernels.scene.Scene`.

What counts is what the viewport's dependency graph holds, in -b as well: modifiers as the viewport shows them, and no
objects that are hidden there. Of those, what is switched off for rendering neither lights nor blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

from ..kernels.scene import WATER_IOR, Scene, Water
from .absorption import read_sigma_a
from .casters import MeshReader
from .errors import DappleError
from .lamps import read_lights
from .medium import read_eta
from .mesh_arrays import read_geometry, read_normals, read_uvs
from .receivers import Maps, can_receive, map_name, shows_receivers
from .speculars import MOST_ROUGHNESS
from .volume import read_volume

_NOTHING = (
    "Nothing bends light or mirrors it: pick the water, or give an object glass or polished metal (Principled, Glass, "
    f"Refraction, Glossy or Metallic of roughness {MOST_ROUGHNESS} or less)."
)
_SLOPE = 1e-3  # of the water: an error in it that moves light by a millimetre per metre of depth
_UNMOVED = np.eye(4)
_SHOWN = {"MESH", "CURVE", "SURFACE", "META", "FONT", "LIGHT"}


@dataclass
class _Found:
    """What one pass over the dependency graph finds; the parts of water by their object's name."""

    water: dict = field(default_factory=dict)
    maps: Maps = field(default_factory=Maps)
    meshes: MeshReader = field(default_factory=MeshReader)
    lamps: list = field(default_factory=list)
    seen: set = field(default_factory=set)
    warnings: list = field(default_factory=list)


def read_scene(depsgraph, water_names, receiver_names, topology, volume=None):
    """(Scene, warnings) of the frame that the depsgraph was evaluated for; several water objects are joined into one.

    water_names, receiver_names: names of mesh objects, water may be missing where something else casts; topology: a
    TopologyCache, the same for all frames of a bake; volume: a `volume.Bounds` for the casters, or None.
    Raises DappleError for what cannot be baked, naming the object.
    """
    for name in water_names:
        _check_object(name)
    for name in receiver_names:
        _check_object(name, can_receive)
    found = _find(depsgraph, set(water_names), set(receiver_names))
    for name in (*water_names, *receiver_names):
        if name not in found.water and name not in found.maps.owners:
            raise DappleError(
                f"Object '{name}' is not in the scene as the viewport shows it; unhide it and its collection there."
            )
    parts = [found.water[name] for name in water_names]
    water, eta, sigma_a = _join(parts, topology, found.warnings) if parts else (_no_water(), WATER_IOR, np.zeros(3))
    casters, occluders = tuple(found.meshes.casters), tuple(found.meshes.occluders)
    if not parts and not casters:
        raise DappleError(" ".join([_NOTHING, *dict.fromkeys(found.meshes.warnings)]))
    lights, remarks = read_lights(found.lamps, water)
    remarks += found.meshes.warnings + _unseen(depsgraph, found.seen, {*water_names, *receiver_names})
    box = read_volume(volume, depsgraph) if volume else None
    scene = Scene(water, found.maps.receivers(), occluders, lights, eta, sigma_a, casters, box)
    return scene, list(dict.fromkeys(found.warnings + remarks))


def _check_object(name, serves=lambda found: found.type == "MESH"):
    """Raise DappleError unless `name` is an object of the file that `serves`."""
    found = bpy.data.objects.get(name)
    if found is None:
        raise DappleError(f"There is no object '{name}' in the file; check the name or pick another object.")
    if not serves(found):
        raise DappleError(f"Object '{name}' is a {found.type.lower()}, not a mesh; convert it (Object > Convert).")


def _find(depsgraph, water_names, receiver_names):
    """Sort everything that the depsgraph shows; curves, texts and metaballs come as mesh instances of themselves."""
    found, rendering = _Found(), _rendering(depsgraph)
    for instance in depsgraph.object_instances:
        shown = instance.object
        name = shown.original.name
        owner = instance.parent.original.name if instance.is_instance and instance.parent else name
        found.seen.add(owner)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        if not instance.is_instance and name in water_names:
            found.water[name] = _read_water(shown, matrix)
            found.warnings += _coarse(name, found.water[name][1], matrix)
        elif not instance.is_instance and name in receiver_names:
            _add_receiver(found, shown, matrix)
        elif {name, owner} & water_names:
            found.warnings.append(f"Instances of or on water '{owner}' were left out; make them real to bake them.")
        elif owner not in rendering or shown.original.hide_render or _stands_in(instance):
            continue
        elif instance.is_instance and owner in receiver_names and shows_receivers(instance):
            found.maps.add_instance(instance, matrix, _read_receiver)
        elif shown.type == "LIGHT":
            found.lamps.append((name, shown.data, matrix))
        elif shown.type == "MESH" and _blocks(shown, instance.parent if instance.is_instance else None):
            found.meshes.add(shown, matrix)
    return found


def _rendering(depsgraph):
    """The view layer's objects, by name, that are not switched off for rendering, themselves or by a collection."""

    def objects(layer):
        if layer.collection.hide_render:
            return
        if not layer.exclude:
            yield from (o for o in layer.collection.objects if not o.hide_render)
        for child in layer.children:
            yield from objects(child)

    return {o.name: o for o in objects(depsgraph.view_layer.layer_collection)}


def _stands_in(instance):
    """Whether an object is only the model of the instances at its parent's vertices or faces, which no render shows."""
    parent = instance.object.parent
    return not instance.is_instance and parent is not None and parent.instance_type in ("VERTS", "FACES")


def _blocks(shown, parent):
    """Whether a mesh, or instance of one, casts a shadow in a render."""
    if not shown.visible_shadow or (parent is not None and not parent.visible_shadow):
        return False
    return parent is not None or not shown.is_instancer or shown.show_instancer_for_render


def _read(shown, matrix, *readers):
    """[MeshArrays, what each reader makes of it] of an evaluated object."""
    mesh = shown.to_mesh()
    try:
        arrays = read_geometry(mesh, matrix)
        return [arrays, *(reader(mesh, arrays) for reader in readers)]
    finally:
        shown.to_mesh_clear()


def _read_water(shown, matrix):
    """(name, MeshArrays, (normals, normal_triangles), (eta, warnings), (sigma_a, warnings)) of a water object."""
    name = shown.original.name
    arrays, normals = _read(shown, matrix, lambda mesh, arrays: read_normals(mesh, matrix, arrays))
    _check_mesh(f"Water '{name}'", arrays)
    return name, arrays, normals, read_eta(shown), read_sigma_a(shown)


def _add_receiver(found, shown, matrix):
    """Add an evaluated object to the maps; one that only shows instances which receive has no mesh of its own."""
    own = shown.original
    if own.type != "MESH" or (own.dapple.instances_receive and not len(shown.data.polygons)):
        found.maps.owners.update({own.name} if own.type == "MESH" else ())
        return
    found.maps.add(own.name, map_name(own), *_read_receiver(shown, matrix))


def _read_receiver(shown, matrix=_UNMOVED):
    """MeshArrays and UVs of an evaluated object."""
    name = shown.original.name
    arrays, uvs = _read(shown, matrix, read_uvs)
    _check_mesh(f"Receiver '{name}'", arrays)
    if uvs is None:
        raise DappleError(f"Receiver '{name}' has no UV map; unwrap it (in Edit Mode: UV > Lightmap Pack).")
    return arrays, uvs


def _check_mesh(what, arrays):
    """Raise DappleError for a mesh without faces or with vertices that are not numbers."""
    if not len(arrays.triangles):
        raise DappleError(f"{what} has no faces after its modifiers; check them, or pick another object.")
    broken = np.count_nonzero(~np.isfinite(arrays.positions).all(axis=1))
    if broken:
        raise DappleError(
            f"{what} has coordinates that are not numbers at {broken} of its {len(arrays.positions)} vertices; "
            "check its modifiers, drivers and cache for divisions by zero."
        )


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


def _join(parts, topology, warnings):
    """(Water, eta, sigma_a) of the parts that `_read_water` gives."""
    names, meshes, shadings, indices, absorptions = zip(*parts)
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    triangles = np.concatenate([mesh.triangles + n for mesh, n in zip(meshes, starts.astype(np.int32))])
    triangles, twins = topology.settle(triangles)
    smooth = all(index is mesh.triangles for (_, index), mesh in zip(shadings, meshes))
    starts = np.cumsum([0] + [len(normals) for normals, _ in shadings]).astype(np.int32)
    shaded = triangles if smooth else np.concatenate([index + n for (_, index), n in zip(shadings, starts)])
    for _, remarks in (*indices, *absorptions):
        warnings += remarks
    eta, sigma_a = indices[0][0], absorptions[0][0]
    if len({other for other, _ in indices}) > 1:
        warnings.append(f"The water objects differ in IOR; the bake takes {eta:.4g}, that of '{names[0]}'.")
    if any((other != sigma_a).any() for other, _ in absorptions):
        warnings.append(f"The water objects differ in what they absorb; the bake takes that of '{names[0]}'.")
    positions = np.concatenate([mesh.positions for mesh in meshes])
    normals = np.concatenate([normals for normals, _ in shadings])
    return Water(" + ".join(names), positions, triangles, normals, shaded, twins), eta, sigma_a


def _no_water():
    """Water without triangles, of a scene in which only other things cast."""
    none = np.zeros((0, 3), np.int32)
    return Water("", np.zeros((0, 3)), none, np.zeros((0, 3)), none, np.zeros(0, np.int32))


def _unseen(depsgraph, seen, asked):
    """Warnings on what a render would show but the viewport hides."""
    rendering = _rendering(depsgraph)
    hidden = sorted(n for n, o in rendering.items() if n not in seen | asked and o.type in _SHOWN and o.visible_shadow)
    return [f"Object '{name}' renders but is hidden in the viewport; it took no part in the bake." for name in hidden]
