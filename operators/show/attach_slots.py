"""Which material of a receiver may be changed: its own, or a copy where others use it too.

A copy carries COPY and, if there was one, ORIGINAL: the material that `restore` puts back (a pointer, so the original
is not lost while only copies are in use). The object keeps, in SLOTS, how each slot was linked before.
"""

from __future__ import annotations

import bpy

COPY = "dapple_copy"
ORIGINAL = "dapple_original"
SLOTS = "dapple_slots"
ADDED = "ADDED"


def make_own(obj: bpy.types.Object) -> tuple[list[bpy.types.Material], list[str]]:
    """Give `obj` materials that nothing else shows; return these, and a sentence for every one that is new.

    Called again, it keeps the copies that it made, and with them what was changed in them since.
    """
    notes, own = [], {}
    slots = obj[SLOTS].to_dict() if SLOTS in obj else {}
    if not obj.material_slots:
        obj.data.materials.append(None)
        slots["0"] = ADDED
    for index, slot in enumerate(obj.material_slots):
        material = slot.material
        if material is None or not _is_own(obj, material):
            if material not in own:
                own[material], note = _copy(obj, material)
                notes.append(note)
            slots.setdefault(str(index), slot.link)
            _put(obj, slot, own[material])
        else:
            own[material] = material
    obj[SLOTS] = slots
    return list(own.values()), notes


def restore(obj: bpy.types.Object) -> None:
    """Put back the materials and slots as they were before `make_own`, and remove the copies."""
    slots = obj[SLOTS].to_dict()
    for index, slot in enumerate(obj.material_slots):
        copy, link = slot.material, slots.get(str(index))
        if link is None or copy is None or COPY not in copy:
            continue
        _take_back(slot, copy.get(ORIGINAL), link)
        if copy.users == 0:
            bpy.data.materials.remove(copy)
    if slots.get("0") == ADDED and len(obj.material_slots) == 1 and obj.material_slots[0].material is None:
        obj.data.materials.clear()
    del obj[SLOTS]


def _is_own(obj, material):
    """Whether `material` can be edited and only `obj` shows it."""
    if material.library or material.override_library or not _has_nodes(material):
        return False
    users = bpy.data.user_map(subset={material})[material]
    return not users - {obj, obj.data} and not (obj.data in users and _is_shared(obj.data))


def _is_shared(mesh):
    return mesh.users - mesh.use_fake_user > 1


def _copy(obj, material):
    """Return a material for `obj` alone that looks like `material` (None: as an empty slot does), and a sentence."""
    # A copy of ours, met on a duplicate of a receiver: go back to what it was made from.
    original = material.get(ORIGINAL) if material and COPY in material else material
    if original is None:
        copy = bpy.data.materials.new(f"Dapple {obj.name}")
        note = f"'{obj.name}' had an empty material slot: it shows a plain grey material now."
    else:
        copy = original.copy()
        copy[ORIGINAL] = original
        note = f"'{obj.name}' shows a copy of '{original.name}', which is used elsewhere or cannot be edited."
    if not _has_nodes(copy):
        _use_nodes(copy)
    copy[COPY] = True
    return copy, note


def _has_nodes(material):
    # From 5.0 on every material has, and asking is deprecated.
    return bpy.app.version >= (5, 0) or material.use_nodes


def _use_nodes(material):
    """Turn on nodes and keep the look of a material that had none."""
    colour, roughness, metallic = tuple(material.diffuse_color), material.roughness, material.metallic
    material.use_nodes = True
    for node in material.node_tree.nodes:
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            node.inputs["Base Color"].default_value = colour
            node.inputs["Roughness"].default_value = roughness
            node.inputs["Metallic"].default_value = metallic


def _put(obj, slot, material):
    """Show `material` in one slot of `obj`, and on no other object."""
    if slot.link == "DATA" and (_is_shared(obj.data) or obj.data.library):
        slot.link = "OBJECT"
    slot.material = material


def _take_back(slot, original, link):
    if slot.link == "OBJECT" and link != "OBJECT":
        # The mesh's own slot was never touched.
        slot.material = None
        slot.link = "DATA"
    else:
        slot.material = original
