"""One frame of a Blender scene as a `kernels.scene.Scene`.

What counts is what the viewport's dependency graph holds, in -b as well: modifiers as the viewport shows them, and no
objects that are hidden there. Of those, what is switched off for rendering neither lights nor blocks.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...kernels.scene import Scene
from ..errors import DappleError
from .caches import missing_caches
from .casters import MeshReader
from .find import can_be_water, checked_object
from .lamps import read_lights
from .mesh_arrays import check_mesh, read_geometry, read_uvs
from .receivers import Maps, can_receive, flat_parts, map_name, shows_receivers
from .speculars import MOST_ROUGHNESS
from .volume import misses, read_volume
from .water import Waters

_NOTHING = (
    "Nothing bends light or mirrors it: pick the water, or give an object glass or polished metal (Principled, Glass, "
    f"Refraction, Glossy or Metallic of roughness {MOST_ROUGHNESS} or less)."
)
_UNMOVED = np.eye(4)
_SHOWN = {"MESH", "CURVE", "SURFACE", "META", "FONT", "LIGHT"}


@dataclass
class _Found:
    """What one pass over the dependency graph finds."""

    waters: Waters
    maps: Maps = field(default_factory=Maps)
    meshes: MeshReader = field(default_factory=MeshReader)
    lamps: list = field(default_factory=list)
    seen: set = field(default_factory=set)


def read_scene(depsgraph, water_names, receiver_names, topology, volume=None):
    """(Scene, warnings) of the frame that the depsgraph was evaluated for; several water objects are joined into one.

    water_names, receiver_names: names of objects, water may be missing where something else casts; topology: a
    TopologyCache, the same for all frames of a bake; volume: a `volume.Bounds` for the casters, or None.
    Raises DappleError for what cannot be baked, naming the object.
    """
    picked = [checked_object(name, can_be_water) for name in water_names]
    receivers = [checked_object(name, can_receive) for name in receiver_names]
    found = _find(depsgraph, picked, set(receivers))
    for obj in (*picked, *receivers):
        if obj not in found.waters.seen and obj.name not in found.maps.owners:
            raise DappleError(
                f"Object '{obj.name}' is not in the scene as the viewport shows it; unhide it and its collection there."
            )
    water, eta, sigma_a, warnings = found.waters.joined(topology)
    warnings += missing_caches((*picked, *receivers))
    casters, occluders = tuple(found.meshes.casters), tuple(found.meshes.occluders)
    if not picked and not casters:
        raise DappleError(" ".join([_NOTHING, *dict.fromkeys(found.meshes.warnings)]))
    lights, remarks = read_lights(found.lamps, water)
    warnings += remarks + found.meshes.warnings + _unseen(depsgraph, found.seen, {*picked, *receivers})
    box = read_volume(volume, depsgraph) if volume else None
    if box:
        warnings += misses(box, volume.name, casters)
    scene = Scene(water, found.maps.receivers(), occluders, lights, eta, sigma_a, casters, box)
    warnings += flat_parts(scene.receivers)
    return scene, list(dict.fromkeys(warnings))


def _find(depsgraph, picked, receivers):
    """Sort everything that the depsgraph shows; curves, texts and metaballs come as mesh instances of themselves."""
    found, rendering = _Found(Waters(picked)), _rendering(depsgraph)
    for instance in depsgraph.object_instances:
        shown = instance.object
        own = shown.original
        owner = instance.parent.original if instance.is_instance and instance.parent else own
        found.seen.add(owner)
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        if found.waters.take(instance, matrix):
            continue
        if not instance.is_instance and own in receivers:
            _add_receiver(found, shown, matrix)
        elif owner not in rendering or own.hide_render or _stands_in(instance):
            continue
        elif instance.is_instance and owner in receivers and shows_receivers(instance):
            found.maps.add_instance(instance, matrix, _read_receiver)
        elif shown.type == "LIGHT":
            found.lamps.append((own.name, shown.data, matrix))
        elif shown.type == "MESH" and (instance.is_instance or _renders(shown)):
            found.meshes.add(shown, matrix, _casts_shadow(shown, instance.parent if instance.is_instance else None))
    return found


def _rendering(depsgraph):
    """The view layer's objects that are not switched off for rendering, themselves or by a collection."""

    def objects(layer):
        if layer.collection.hide_render:
            return
        if not layer.exclude:
            yield from (o for o in layer.collection.objects if not o.hide_render)
        for child in layer.children:
            yield from objects(child)

    return set(objects(depsgraph.view_layer.layer_collection))


def _stands_in(instance):
    """Whether an object is only the model of the instances at its parent's vertices or faces, which no render shows."""
    parent = instance.object.parent
    return not instance.is_instance and parent is not None and parent.instance_type in ("VERTS", "FACES")


def _renders(shown):
    """Whether a mesh that is no instance shows in a render."""
    return not shown.is_instancer or shown.show_instancer_for_render


def _casts_shadow(shown, parent):
    """Whether a mesh, or instance of one, casts a shadow in a render."""
    return shown.visible_shadow and (parent is None or parent.visible_shadow)


def _read(shown, matrix, *readers):
    """[MeshArrays, what each reader makes of it] of an evaluated object."""
    mesh = shown.to_mesh()
    try:
        arrays = read_geometry(mesh, matrix)
        return [arrays, *(reader(mesh, arrays) for reader in readers)]
    finally:
        shown.to_mesh_clear()


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
    check_mesh(f"Receiver '{name}'", arrays)
    if uvs is None:
        raise DappleError(f"Receiver '{name}' has no UV map; unwrap it, or press Make Lightmap UVs.")
    return arrays, uvs


def _unseen(depsgraph, seen, asked):
    """Warnings on what a render would show but the viewport hides."""
    unseen = _rendering(depsgraph) - seen - asked
    hidden = sorted(o.name for o in unseen if o.type in _SHOWN and o.visible_shadow)
    return [f"Object '{name}' renders but is hidden in the viewport; it took no part in the bake." for name in hidden]
