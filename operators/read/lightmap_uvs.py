"""UV maps for receivers that have none: unwrapped and packed by Blender itself, in a layer of their own.

The work is done on a copy of the mesh in a scene for the purpose, so that the artist's layers, selection, hidden faces
and mode stay as they are.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Matrix

from ..errors import DappleError
from .find import find_object, shown_by
from .mesh_arrays import LAYER, lightmap_layer, read_geometry

_ANGLES = 66, 40, 20, 8, 2  # degrees between faces of one island: smaller where islands overlap themselves
_ENOUGH = 1e-4  # of the texels, that may lie in two islands: edges of float32
_CHECKED = 512  # texels along the side of the map on which that is counted
_LIMIT = 64  # of a map's side: the margin is no wider than this part of it


def supply(context, request) -> str:
    """Give the receivers of a BakeRequest that have no UV map one each; returns a sentence on which, empty where none
    lacks one.

    The gaps between islands follow from the resolution and padding of its settings. Raises DappleError for a mesh that
    cannot be given one.
    """
    depsgraph = context.evaluated_depsgraph_get()
    objects = [shown for name in request.receivers for shown in shown_by(find_object(name)) if shown.type == "MESH"]
    lacking = [obj for obj in objects if _lacks(obj, depsgraph)]
    return make(context, lacking, request.settings)


def make(context, objects, settings) -> str:
    """As `supply`, for all of these objects, whatever UV maps they have; an earlier layer of ours is made anew."""
    meshes = {obj.data: obj for obj in objects}
    for obj in meshes.values():
        _check(obj)
    for mesh, obj in meshes.items():
        _write(mesh, _unwrap(obj, settings))
    if meshes:
        context.view_layer.update()
    names = ", ".join(f"'{obj.name}'" for obj in meshes.values())
    return f"Made the UV map '{LAYER}' for {names}, to lay out their lightmaps by." if meshes else ""


def _lacks(obj, depsgraph):
    """Whether a mesh object has faces and, after its modifiers, no UV map."""
    mesh = obj.evaluated_get(depsgraph).data
    return len(mesh.polygons) > 0 and not lightmap_layer(mesh)


def _check(obj):
    """Raise DappleError for an object whose mesh cannot be given a UV map."""
    mesh, why = obj.data, ""
    if not mesh.polygons:
        why = f"modifiers make its faces; let them store a UV map '{LAYER}', or apply them"
    elif mesh.library:
        why = f"its mesh is linked from {mesh.library.filepath}; unwrap it there, or make it local"
    elif mesh.is_editmode:
        why = "it is in Edit Mode; leave that"
    elif len(mesh.uv_layers) > 7 and LAYER not in mesh.uv_layers:
        why = "it has eight UV maps, the most that Blender takes; remove one"
    if why:
        raise DappleError(f"Receiver '{obj.name}' cannot be given a UV map: {why}.")


def _unwrap(obj, settings):
    """UVs (L,2) of an object's mesh, as it lies in the world, in islands that do not overlap, if Blender finds any."""
    margin = min(max(settings.padding, 1), settings.resolution / _LIMIT) / settings.resolution
    best, least = None, np.inf
    for angle in _ANGLES:
        uvs, overlap = _projected(obj, math.radians(angle), margin)
        if overlap < least:
            best, least = uvs, overlap
        if overlap <= _ENOUGH:
            break
    return best


def _projected(obj, angle, margin):
    """UVs (L,2) by smart projection and packing, and which share of the texels lies in more than one island."""
    from ...kernels.maps.texels import overlap

    mesh = obj.data.copy()
    copy = bpy.data.objects.new(mesh.name, mesh)
    scene = bpy.data.scenes.new("Dapple")
    try:
        _prepare(copy, obj)
        scene.collection.objects.link(copy)
        _project(scene, copy, angle, margin)
        uvs = np.empty((len(mesh.loops), 2), dtype=np.float32)
        mesh.uv_layers.active.uv.foreach_get("vector", uvs.ravel())
        corners = read_geometry(mesh, np.eye(4)).corners
        return uvs, overlap(uvs.astype(np.float64)[corners], _CHECKED)
    finally:
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        bpy.data.scenes.remove(scene)


def _prepare(copy, obj):
    """Leave a copy of an object nothing but its faces, all of them, as large as in the world."""
    mesh = copy.data
    if mesh.shape_keys:
        copy.shape_key_clear()
    for name in [a.name for a in mesh.attributes if a.name.startswith(".hide")]:
        mesh.attributes.remove(mesh.attributes[name])
    while mesh.uv_layers:
        mesh.uv_layers.remove(mesh.uv_layers[0])
    mesh.uv_layers.new(name=LAYER)
    mesh.transform(Matrix.Diagonal((*(abs(s) or 1.0 for s in obj.matrix_world.to_scale()), 1.0)))


def _project(scene, copy, angle, margin):
    """Unwrap the only object of a scene by Blender's operators."""
    layer = scene.view_layers[0]
    layer.objects.active = copy
    copy.select_set(True, view_layer=layer)
    words = {"scene": scene, "view_layer": layer, "object": copy, "active_object": copy, "selected_objects": [copy]}
    with bpy.context.temp_override(**words):
        bpy.ops.object.mode_set(mode="EDIT")
    with bpy.context.temp_override(**words, edit_object=copy):
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.smart_project(angle_limit=angle, island_margin=0.0, correct_aspect=False)
        bpy.ops.uv.select_all(action="SELECT")
        bpy.ops.uv.average_islands_scale()
        bpy.ops.uv.pack_islands(margin=margin, margin_method="FRACTION", shape_method="AABB")  # others take minutes
        bpy.ops.object.mode_set(mode="OBJECT")


def _write(mesh, uvs):
    """Put UVs (L,2) into our layer of a mesh, and leave the layers that are active as they are."""
    if LAYER not in mesh.uv_layers:
        known = [(layer.name, layer.active_render, layer.active_clone) for layer in mesh.uv_layers]
        active = mesh.uv_layers.active_index
        mesh.uv_layers.new(name=LAYER, do_init=False)
        if known:
            mesh.uv_layers.active_index = active
        for name, renders, clones in known:
            mesh.uv_layers[name].active_render = renders or mesh.uv_layers[name].active_render
            mesh.uv_layers[name].active_clone = clones or mesh.uv_layers[name].active_clone
    mesh.uv_layers[LAYER].uv.foreach_set("vector", uvs.ravel())
    mesh.update()
