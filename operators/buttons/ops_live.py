"""The switch of the live preview."""

from __future__ import annotations

import bpy

from ..errors import DappleError
from ..show import live
from .choose import choose, wants_choice
from .explained import Explained, choice_lacking


class DAPPLE_OT_live_preview(Explained, bpy.types.Operator):
    """Bake each frame that you come to as a draft of 256 texels and show it on the receivers, in memory only. \
Switched off, before saving and before rendering, the maps on disk are shown again"""

    bl_idname = "dapple.live_preview"
    bl_label = "Live Preview"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacks(cls, context):
        if context.window_manager.dapple.running:
            return "A bake is running: stop it first"
        return "" if live.is_on() else choice_lacking(context)

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
