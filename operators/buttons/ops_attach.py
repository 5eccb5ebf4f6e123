"""The buttons that show the baked maps on the receivers, let EEVEE look at them, and take them off."""

from __future__ import annotations

import bpy

from ..bake.bake import request_from_scene
from ..errors import DappleError
from ..read.casters import caster_names
from ..show import live
from ..show.attach import attach, detach
from ..show.attach_shadow import made_opaque
from ..show.attach_slots import SLOTS
from ..show.attach_view import look_through, unseen
from .explained import Explained


class DAPPLE_OT_attach(Explained, bpy.types.Operator):
    """Light the receivers' materials by the baked maps, and let water, glass and metal cast whole shadows. \
Press it again after a new bake or a change of materials"""

    bl_idname = "dapple.attach"
    bl_label = "Attach to Materials"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            live.stop(context)
            # The frames that are on disk are shown, whatever the range says now.
            request = request_from_scene(context.scene, frames=(context.scene.frame_current,))
            casters = caster_names(context.evaluated_depsgraph_get(), {*request.water, *request.receivers})
            notes = attach(context, request.receivers, request.out, (*request.water, *casters))
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(request.receivers)} receiver(s) show their maps")
        # Last, for the status bar shows the last report only.
        for note in notes:
            self.report({"WARNING"}, note)
        return {"FINISHED"}


class DAPPLE_OT_detach(Explained, bpy.types.Operator):
    """Take the maps off all materials and leave these, and the shadows, as they were before"""

    bl_idname = "dapple.detach"
    bl_label = "Detach"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacks(cls, _context):
        return "" if any(SLOTS in obj for obj in bpy.data.objects) else "No object shows its maps"

    def execute(self, context):
        live.stop(context)
        names = detach(context)
        self.report({"INFO"}, f"{len(names)} object(s) show no map any more")
        return {"FINISHED"}


class DAPPLE_OT_look_through(Explained, bpy.types.Operator):
    """Let EEVEE show what lies behind water and glass: turn on Raytracing in the render properties, and Raytraced \
Transmission in their materials. Detach leaves both on"""

    bl_idname = "dapple.look_through"
    bl_label = "Look Through Water"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacks(cls, context):
        casters = made_opaque(context.scene)
        if not casters:
            return "No maps are shown: attach them first"
        return "" if unseen(context.scene, casters) else "Nothing hides what lies behind water and glass"

    def execute(self, context):
        for sentence in look_through(context.scene, made_opaque(context.scene)):
            self.report({"WARNING"}, sentence)
        return {"FINISHED"}
