"""Show the baked maps on the receivers, and take them off again.

An object that shows its map has the custom property `attach_slots.SLOTS`; all that is added to the file is tagged, and
found by its tags rather than by references, which an undo would break.
"""

from __future__ import annotations

import bpy

from ..errors import DappleError
from ..read.find import find_object, shown_by
from ..read.mesh_arrays import LAYER
from ..read.receivers import map_name
from ..read.tiles import of_tile
from . import attach_files, attach_nodes, attach_shadow, attach_slots, attach_view, map_nodes

_UNSEEN = (
    "The instances of '{}' have maps, but share their materials and cannot show them: make them real and bake again."
)


def attach(context: bpy.types.Context, receiver_names, out_dir, caster_names=()) -> list[str]:
    """Light the materials of each receiver by its maps in `out_dir`, and make water and casters cast whole shadows.

    Done twice it is as done once, with the maps read anew. Returns sentences on what the user should know. Raises
    DappleError, before anything is changed, for an object that is missing or cannot be edited and for maps not found.
    """
    notes = [_UNSEEN.format(name) for name in receiver_names if _object(name).type == "EMPTY"]
    receivers = [_receiver(name) for name in receiver_names if _object(name).type != "EMPTY"]
    casters = [shown for name in caster_names for shown in shown_by(_named(name))]
    maps = [attach_files.find_maps(map_name(receiver), out_dir) for receiver in receivers]
    # What is attached already goes first, so that no copy is made of it.
    for receiver in receivers:
        _strip(receiver)
    for receiver, tiles in zip(receivers, maps, strict=True):
        notes += _attach_one(receiver, tiles) + _out_of_reach(receiver, context.evaluated_depsgraph_get())
    attach_files.remove_unused_images()
    for caster in casters:
        attach_shadow.make_opaque(caster)
    notes += attach_shadow.doubts(context.scene, casters)
    return notes + attach_view.unseen(context.scene, casters)


def refresh(receiver_names, out_dir) -> None:
    """After a bake, read the maps in `out_dir` anew on the receivers that show one; raises DappleError as `attach`."""
    for obj in bpy.data.objects:
        if obj.name in receiver_names and attach_slots.SLOTS in obj:
            tiles = attach_files.find_maps(map_name(obj), out_dir)
            _show(obj, attach_files.load(map_name(obj), tiles))
    attach_files.remove_unused_images()


def show_images(context, receiver_names, images, caster_names) -> list[bpy.types.Object]:
    """Let the receivers show images in memory, {map: image}, in place of their files; returns the objects that showed
    no map before, which are lit as `attach` lights them."""
    shown = [_receiver(name) for name in receiver_names if _object(name).type != "EMPTY"]
    new = [obj for obj in shown if attach_slots.SLOTS not in obj]
    for obj in shown:
        sequences = _in_memory(map_name(obj), images)
        if obj in new:
            _light(obj, sequences)
        else:
            _show(obj, sequences)
    for name in caster_names if new else ():
        for caster in shown_by(_named(name)):
            attach_shadow.make_opaque(caster)
    return new


def show_maps() -> None:
    """Let every receiver that shows an image in memory show the files again that it showed before."""
    for obj in [obj for obj in bpy.data.objects if attach_slots.SLOTS in obj]:
        if sequences := attach_files.loaded(map_name(obj)):
            _show(obj, sequences)


def detach(context: bpy.types.Context, receiver_names=None) -> list[str]:
    """Take the maps off the receivers, off all objects of the file if None, and leave materials as they were.

    With the last one the casters' shadows go back to what they were. Returns the names of objects that showed a map.
    """
    attached = [obj for obj in bpy.data.objects if attach_slots.SLOTS in obj]
    chosen = [obj for obj in attached if receiver_names is None or obj.name in receiver_names]
    for obj in chosen:
        _strip(obj)
        attach_slots.restore(obj)
    attach_files.remove_unused_images()
    if len(chosen) == len(attached):
        attach_shadow.restore()
    return [obj.name for obj in chosen]


def _attach_one(receiver, tiles):
    notes = _light(receiver, attach_files.load(map_name(receiver), tiles))
    frames = set.intersection(*map(set, tiles.values()))
    numbers = {number for files in tiles.values() for number in files}
    missing = sorted(set(range(min(numbers), max(numbers) + 1)) - frames)
    if missing:
        notes.append(f"'{receiver.name}' has no map for {len(missing)} frame(s) from {missing[0]} on: bake these too.")
    return notes


def _show(obj, sequences):
    """Let the nodes of an attached object show Sequences; new nodes where these are others than those were made for."""
    trees = _trees(obj)
    if all(map_nodes.update(tree, sequences) for tree in trees):
        return
    for tree in trees:
        attach_nodes.strip(tree)
    _light(obj, sequences)


def _in_memory(name, images):
    """The Sequences of the images, {map: image}, of a name: one, or one a tile."""
    if name in images:
        return (map_nodes.Sequence(images[name], 1, 1),)
    tiles = {
        tile: image for (owner, tile), image in zip(map(of_tile, images), images.values(), strict=True) if owner == name
    }
    return tuple(map_nodes.Sequence(tiles[tile], 1, 1, tile=tile) for tile in sorted(tiles))


def _light(receiver, sequences):
    """Add the light of Sequences to the materials of a receiver; returns sentences on what the user should know."""
    materials, notes = attach_slots.make_own(receiver)
    # Baked by our own UV map or the one that renders; one that only modifiers make is no layer of the mesh, and empty
    # means it too.
    layers = receiver.data.uv_layers
    uv_map = LAYER if LAYER in layers else next((layer.name for layer in layers if layer.active_render), "")
    for material in materials:
        # It may be a copy of a material that shows the map of an object that is not attached now.
        attach_nodes.strip(material.node_tree)
        if not attach_nodes.add(material.node_tree, sequences, uv_map):
            notes.append(
                f"No diffuse colour was found in '{material.name}' of '{receiver.name}': it is lit as if white."
            )
    return notes


def _out_of_reach(receiver, depsgraph):
    """Say which materials come from a modifier: they are in no slot, and cannot be lit."""
    slots = {slot.material for slot in receiver.material_slots}
    shown = {m.original for m in receiver.evaluated_get(depsgraph).data.materials if m}
    return [
        f"A modifier of '{receiver.name}' sets the material '{material.name}': it does not show the map. Set it in a "
        "slot instead."
        for material in shown - slots
    ]


def _strip(obj):
    for tree in _trees(obj):
        attach_nodes.strip(tree)


def _trees(obj):
    """Node trees of the materials of `obj` that can be edited, each once."""
    materials = {slot.material for slot in obj.material_slots} - {None}
    return [material.node_tree for material in materials if material.node_tree and not material.library]


def _receiver(name):
    obj = _object(name)
    if obj.type != "MESH":
        raise DappleError(f"The receiver '{name}' is not a mesh: convert it, or take it out of the receivers.")
    if obj.data.library and not obj.material_slots:
        raise DappleError(f"The mesh of '{name}' is linked and has no material slot: give it a material there.")
    return obj


def _named(name):
    obj = find_object(name)
    if obj is None:
        raise DappleError(f"There is no object '{name}': choose it again.")
    return obj


def _object(name):
    obj = _named(name)
    if obj.library:
        raise DappleError(f"'{name}' is linked from another file: make a library override of it first.")
    return obj
