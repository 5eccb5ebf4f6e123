"""Water, glass and mirrors while maps are shown: no light but the maps' may come through them to the receivers.

Their shadow must be whole, or the sun lights the receivers beside the map. And in Cycles the rays that a diffuse
surface sends out must not meet them: bent towards the sun, they would find the caustics a second time, with noise. Past
them they find the sky as it is; a ray that meets the sun itself counts next to nothing, since lamps are sampled too.

The former values stay with the object and the material, under SHADOW and DIFFUSE, until `restore`.
"""

from __future__ import annotations

import bpy

SHADOW = "dapple_shadow"
DIFFUSE = "dapple_diffuse"


def make_opaque(caster: bpy.types.Object) -> None:
    """Let `caster` cast a full shadow, whatever its materials let through, and be passed by Cycles' diffuse rays."""
    if not caster.library:
        if SHADOW not in caster:
            caster[SHADOW], caster[DIFFUSE] = caster.visible_shadow, caster.visible_diffuse
        caster.visible_shadow, caster.visible_diffuse = True, False
    for material in {slot.material for slot in caster.material_slots} - {None}:
        if material.library:
            continue
        if SHADOW not in material:
            material[SHADOW] = (material.use_transparent_shadow, material.use_backface_culling_shadow)
        material.use_transparent_shadow = False
        material.use_backface_culling_shadow = False


def made_opaque(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The objects of a scene that `make_opaque` has changed: water, glass and mirrors while maps are shown."""
    return [obj for obj in scene.objects if SHADOW in obj]


def restore() -> None:
    """Put back what `make_opaque` changed, in the whole file."""
    for obj in bpy.data.objects:
        if SHADOW in obj:
            obj.visible_shadow, obj.visible_diffuse = bool(obj[SHADOW]), bool(obj.get(DIFFUSE, True))
            del obj[SHADOW]
            if DIFFUSE in obj:
                del obj[DIFFUSE]
    for material in bpy.data.materials:
        if SHADOW in material:
            material.use_transparent_shadow, material.use_backface_culling_shadow = map(bool, material[SHADOW])
            del material[SHADOW]


def doubts(scene: bpy.types.Scene, casters: list[bpy.types.Object]) -> list[str]:
    """Say what else would let the sun through water and casters: one sentence each, empty if nothing."""
    found = [
        f"Sun '{obj.name}' casts no shadows: it lights the receivers beside the map. Turn on its shadow."
        for obj in scene.objects
        if obj.type == "LIGHT" and obj.data.type == "SUN" and not obj.hide_render and not obj.data.use_shadow
    ]
    # The switch for all shadows came with 4.3.
    if not getattr(scene.eevee, "use_shadows", True):
        found.append("Shadows are off in EEVEE's settings: the sun lights the receivers beside the map. Turn them on.")
    for caster in casters:
        for material in {slot.material for slot in caster.material_slots} - {None}:
            if material.library and (material.use_transparent_shadow or material.use_backface_culling_shadow):
                found.append(
                    f"'{material.name}' of '{caster.name}' is linked from another file and could not be "
                    "changed: turn off its Transparent Shadows and its shadow's Backface Culling there."
                )
    return found
