"""Simulations and caches: what has to be played, or to be on disk, before a frame is what the artist means.

Cloth, soft bodies, dynamic paint, particles, rigid bodies, fluids on replay and simulation zones of geometry nodes make
a frame from the one before. Where no bake of theirs is kept, a jump to a frame shows something else than playing does.
"""

from __future__ import annotations

from pathlib import Path

import bpy

_CACHED = {"CLOTH", "SOFT_BODY"}


class Player:
    """Sets the frames of a scene, by its name; frames between are played where a simulation needs them."""

    def __init__(self, scene_name):
        self._name, self._at = scene_name, None

    def go(self, number):
        """Set frame `number`."""
        scene = bpy.data.scenes[self._name]
        first = min(_starts(scene), default=number)
        played = self._at if self._at is not None and self._at <= number else first - 1
        for between in range(max(played + 1, first), number):
            scene.frame_set(between)
        scene.frame_set(number)
        self._at = number

    @staticmethod
    def plays(scene):
        """Whether frames between have to be played to come to one."""
        return any(True for _ in _starts(scene))


def _starts(scene):
    """The first frames of all simulations of a scene that are not baked."""
    world = scene.rigidbody_world
    caches = [world.point_cache] if world and world.enabled else []
    for obj in scene.objects:
        for modifier in obj.modifiers:
            if modifier.show_viewport:
                caches += _point_caches(modifier)
                yield from _zones(scene, modifier)
    yield from (cache.frame_start for cache in caches if not cache.is_baked)


def _point_caches(modifier):
    """The point caches of a modifier."""
    if modifier.type in _CACHED:
        return [modifier.point_cache]
    if modifier.type == "PARTICLE_SYSTEM":
        return [modifier.particle_system.point_cache]
    if modifier.type == "DYNAMIC_PAINT" and modifier.canvas_settings:
        return [surface.point_cache for surface in modifier.canvas_settings.canvas_surfaces if surface.is_active]
    return []


def _zones(scene, modifier):
    """The first frames of fluids on replay and of simulation zones, of which Blender does not tell whether they are
    baked."""
    if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
        domain = modifier.domain_settings
        yield from [domain.cache_frame_start] if domain.cache_type == "REPLAY" else []
    for kept in modifier.bakes if modifier.type == "NODES" else ():
        if kept.node and kept.node.bl_idname == "GeometryNodeSimulationOutput":
            yield kept.frame_start if kept.use_custom_simulation_frame_range else scene.frame_start


def missing_caches(objects):
    """Sentences on the cache files (Alembic, USD) of objects that are not there."""
    said = []
    for obj in objects:
        for modifier in obj.modifiers:
            cache = getattr(modifier, "cache_file", None)
            if cache and not Path(bpy.path.abspath(cache.filepath, library=cache.library)).exists():
                said.append(
                    f"Object '{obj.name}' takes its shape from '{cache.filepath}', which is not there: it stands "
                    "still. Put the file back, or set its path in the modifier."
                )
    return said
