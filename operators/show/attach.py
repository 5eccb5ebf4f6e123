"""Show the baked maps on the receivers, and take them off again.

An object that shows its map has the custom property `attach_slots.SLOTS`; all that is added to the file is tagged, and
found by its tags rather than by references, which an undo would break.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy

from ..errors import DappleError
from ..maps.write import folder_name
from ..read.find import find_object, shown_by
from ..read.mesh_arrays import LAYER
from ..read.receivers import map_name
from . import attach_nodes, attach_shadow, attach_slots, attach_view

IMAGE = "dapple_map"
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
    maps = [_find_maps(receiver, Path(out_dir)) for receiver in receivers]
    # What is attached already goes first, so that no copy is made of it.
    for receiver in receivers:
        _strip(receiver)
    for receiver, files in zip(receivers, maps, strict=True):
        notes += _attach_one(receiver, files) + _out_of_reach(receiver, context.evaluated_depsgraph_get())
    _remove_unused_images()
    for caster in casters:
        attach_shadow.make_opaque(caster)
    notes += attach_shadow.doubts(context.scene, casters)
    return notes + attach_view.unseen(context.scene, casters)


def refresh(receiver_names, out_dir) -> None:
    """After a bake, read the maps in `out_dir` anew on the receivers that show one; raises DappleError as `attach`."""
    for obj in bpy.data.objects:
        if obj.name in receiver_names and attach_slots.SLOTS in obj:
            sequence = _load(map_name(obj), _find_maps(obj, Path(out_dir)))
            for tree in _trees(obj):
                attach_nodes.update(tree, sequence)
    _remove_unused_images()


def show_images(context, receiver_names, images, caster_names) -> list[bpy.types.Object]:
    """Let the receivers show images in memory, {map: image}, in place of their files; returns the objects that showed
    no map before, which are lit as `attach` lights them."""
    shown = [_receiver(name) for name in receiver_names if _object(name).type != "EMPTY"]
    new = [obj for obj in shown if attach_slots.SLOTS not in obj]
    for obj in shown:
        sequence = attach_nodes.Sequence(images[map_name(obj)], 1, 1)
        if obj in new:
            _light(obj, sequence)
        for tree in _trees(obj):
            attach_nodes.update(tree, sequence)
    for name in caster_names if new else ():
        for caster in shown_by(_named(name)):
            attach_shadow.make_opaque(caster)
    return new


def show_maps() -> None:
    """Let every receiver that shows an image in memory show the files again that it showed before."""
    for obj in [obj for obj in bpy.data.objects if attach_slots.SLOTS in obj]:
        image = next((image for image in bpy.data.images if image.get(IMAGE) == map_name(obj)), None)
        if image is not None:
            files = _maps_in(Path(bpy.path.abspath(image.filepath)).parent)
            sequence = attach_nodes.Sequence(image, min(files, default=1), max(files, default=1))
            for tree in _trees(obj):
                attach_nodes.update(tree, sequence)


def detach(context: bpy.types.Context, receiver_names=None) -> list[str]:
    """Take the maps off the receivers, off all objects of the file if None, and leave materials as they were.

    With the last one the casters' shadows go back to what they were. Returns the names of objects that showed a map.
    """
    attached = [obj for obj in bpy.data.objects if attach_slots.SLOTS in obj]
    chosen = [obj for obj in attached if receiver_names is None or obj.name in receiver_names]
    for obj in chosen:
        _strip(obj)
        attach_slots.restore(obj)
    _remove_unused_images()
    if len(chosen) == len(attached):
        attach_shadow.restore()
    return [obj.name for obj in chosen]


def _attach_one(receiver, files):
    notes = _light(receiver, _load(map_name(receiver), files))
    missing = sorted(set(range(min(files), max(files))) - set(files))
    if missing:
        notes.append(f"'{receiver.name}' has no map for {len(missing)} frame(s) from {missing[0]} on: bake these too.")
    return notes


def _light(receiver, sequence):
    """Add the light of a Sequence to the materials of a receiver; returns sentences on what the user should know."""
    materials, notes = attach_slots.make_own(receiver)
    # Baked by our own UV map or the one that renders; one that only modifiers make is no layer of the mesh, and empty
    # means it too.
    layers = receiver.data.uv_layers
    uv_map = LAYER if LAYER in layers else next((layer.name for layer in layers if layer.active_render), "")
    for material in materials:
        # It may be a copy of a material that shows the map of an object that is not attached now.
        attach_nodes.strip(material.node_tree)
        if not attach_nodes.add(material.node_tree, sequence, uv_map):
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


def _find_maps(receiver, out_dir):
    """Return the maps of one receiver: frame -> file. Raises DappleError if there is none."""
    folder = out_dir / folder_name(map_name(receiver))
    files = _maps_in(folder)
    if not files and any(folder.glob("caustics_*.1???.exr")):
        raise DappleError(
            f"The maps of '{receiver.name}' in {folder} are UDIM tiles, of which Blender plays no sequences: load one "
            "frame as a tiled image, caustics_####.<UDIM>.exr, or lay the UV map out in one tile."
        )
    if not files:
        raise DappleError(f"No lightmaps of '{receiver.name}' in {folder}: bake it first, or set the output folder.")
    return files


def _maps_in(folder):
    """The maps in a folder: frame -> file. OpenEXR as they are baked, else PNG as they are exported."""
    for ending in ("exr", "png"):
        found = sorted(folder.glob(f"caustics_*.{ending}"))
        named = ((re.fullmatch(rf"caustics_(\d+)\.{ending}", path.name), path) for path in found)
        if files := {int(match[1]): path for match, path in named if match}:
            return files
    return {}


def _scale(path):
    """The irradiance that a value of 1 in a map stands for: of PNG what was written beside them."""
    if path.suffix != ".png":
        return 1.0
    told = path.parent / "sequence.json"
    try:
        return float(json.loads(told.read_text(encoding="utf-8"))["value_scale"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DappleError(f"{told} does not tell what the PNG beside it stand for ({error}); export again.") from error


def _load(name, files):
    first, last = min(files), max(files)
    scale = _scale(files[first])
    path = _blend_relative(files[first])
    image = next((image for image in bpy.data.images if image.get(IMAGE) == name), None)
    if image is None:
        image = bpy.data.images.load(path)
        image.name, image[IMAGE] = f"Dapple {name}", name
    # Setting path and source, even to what they were, makes Blender forget the pixels of an earlier bake.
    image.filepath = path
    image.source = "SEQUENCE" if len(files) > 1 else "FILE"
    image.colorspace_settings.name = "Non-Color"
    return attach_nodes.Sequence(image, first, last, scale)


def _remove_unused_images():
    for image in [image for image in bpy.data.images if IMAGE in image and image.users == 0]:
        bpy.data.images.remove(image)


def _strip(obj):
    for tree in _trees(obj):
        attach_nodes.strip(tree)


def _trees(obj):
    """Node trees of the materials of `obj` that can be edited, each once."""
    materials = {slot.material for slot in obj.material_slots} - {None}
    return [material.node_tree for material in materials if material.node_tree and not material.library]


def _blend_relative(path):
    """Write `path` as the .blend file would, so that a project can be moved; as it is where that cannot be."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:  # another drive
        return str(path)


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
