"""What hides the maps from EEVEE: it shows nothing through glass and water unless rays are traced for them."""

from __future__ import annotations

import bpy

from ...kernels.casters import Glass
from ..read.speculars import read_specular

_ENGINES = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}  # the second until 4.5


def unseen(scene: bpy.types.Scene, casters: list[bpy.types.Object]) -> list[str]:
    """Say what keeps EEVEE from showing what lies behind water and casters: a sentence short enough for the status bar,
    none if nothing does or the scene is rendered by another engine."""
    rays, materials = _hidden_by(scene, casters)
    switches = ["Raytracing (render)"] * rays
    if materials:
        names = ", ".join(f"'{material.name}'" for material in materials)
        switches.append(f"Raytraced Transmission (material {names})")
    if not switches:
        return []
    return [
        f"EEVEE hides what lies behind water and glass: press Look Through Water, or turn on {' and '.join(switches)}."
    ]


def look_through(scene: bpy.types.Scene, casters: list[bpy.types.Object]) -> list[str]:
    """Turn on what `unseen` names; returns sentences on what it could not turn on."""
    rays, materials = _hidden_by(scene, casters)
    scene.eevee.use_raytracing = scene.eevee.use_raytracing or rays
    for material in materials:
        if not material.library:
            material.use_raytrace_refraction = True
    return unseen(scene, casters)


def _hidden_by(scene, casters):
    """(whether the scene's own switch is off, the materials whose switch is off) that hide what lies behind casters."""
    if scene.render.engine not in _ENGINES:
        return False, []
    slots = [slot.material for caster in casters for slot in caster.material_slots]
    clear = dict.fromkeys(material for material in slots if _is_glass(material))
    return bool(clear) and not scene.eevee.use_raytracing, [m for m in clear if not m.use_raytrace_refraction]


def _is_glass(material):
    # Blended surfaces are shown by other means than rays, as their maker wants them.
    if material is None or material.surface_render_method == "BLENDED":
        return False
    found = read_specular(material)
    return found is not None and isinstance(found.material, Glass)
