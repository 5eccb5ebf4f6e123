"""The button that gives receivers UV maps for their lightmaps."""

from __future__ import annotations

import bpy

from ..bake.bake import request_from_scene
from ..errors import DappleError
from ..read.find import find_object, shown_by
from ..read.lightmap_uvs import make, supply
from .explained import Explained


class DAPPLE_OT_lightmap_uvs(Explained, bpy.types.Operator):
    """Unwrap receivers for their lightmaps, without overlaps, into the UV map 'Dapple': those that have no UV map, \
and of those that are selected all, anew. Other UV maps stay as they are"""

    bl_idname = "dapple.lightmap_uvs"
    bl_label = "Make Lightmap UVs"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacks(cls, context):
        return "" if context.mode == "OBJECT" else "Go to Object Mode first"

    def execute(self, context):
        try:
            frame = (context.scene.frame_current,)
            request = request_from_scene(context.scene, frames=frame, out=bpy.app.tempdir)
            shown = {mesh for name in request.receivers for mesh in shown_by(find_object(name)) if mesh.type == "MESH"}
            made = make(context, [obj for obj in context.selected_objects if obj in shown], request.settings)
            made = " ".join(filter(None, (made, supply(context, request))))
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, made or "All receivers have UV maps; select those that are to be unwrapped anew.")
        return {"FINISHED"}
