"""What hides the maps from EEVEE: it shows nothing through glass and water unless rays are traced for them."""

from __future__ import annotations

import bpy

from ...kernels.casters import Glass
from ..read.speculars import read_specular

_ENGINES = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}  # the second until 4.5


def unseen(scene: bpy.types.Scene, casters: list[bpy.types.Object]) -> list[str]:
    """Say what keeps EEVEE from showing what lies behind water and casters: a sentence short enough for the status bar,
    none if nothing does or the scene is rendered by another engine."""
    if scene.render.engine not in _ENGINES:
        return []
    clear = {slot.material for caster in casters for slot in caster.material_slots if _is_glass(slot.material)}
    names = ", ".join(f"'{material.name}'" for material in clear if not material.use_raytrace_refraction)
    switches = []
    if clear and not scene.eevee.use_raytracing:
        switches.append("Raytracing (render)")
    if names:
        switches.append(f"Raytraced Transmission (material {names})")
    if not switches:
        return []
    return [f"EEVEE hides what lies behind water and glass: turn on {' and '.join(switches)}."]


def _is_glass(material):
    # Blended surfaces are shown by other means than rays, as their maker wants them.
    if material is None or material.surface_render_method == "BLENDED":
        return False
    found = read_specular(material)
    return found is not None and isinstance(found.material, Glass)
