"""The switch of the live preview."""

from __future__ import annotations

import bpy

from ..errors import DappleError
from ..show import live
from .choose import choose, wants_choice
from .ops_bake import why_not_yet


class DAPPLE_OT_live_preview(bpy.types.Operator):
    """Bake each frame that you come to as a draft of 256 texels and show it on the receivers, in memory only. \
Switched off, before saving and before rendering, the maps on disk are shown again"""

    bl_idname = "dapple.live_preview"
    bl_label = "Live Preview"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        reason = "" if live.is_on() else why_not_yet(context)
        if context.window_manager.dapple.running:
            reason = "A bake is running: stop it first"
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        if live.is_on():
            live.stop(context)
            return {"FINISHED"}
        try:
            said = [choose(context)] if wants_choice(context.scene) else []
            said.append(live.start(context))
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for sentence in filter(None, said):
            self.report({"INFO"}, sentence)
        return {"FINISHED"}
