"""The button that takes water and receivers from the selection."""

from __future__ import annotations

import bpy

from ..errors import DappleError
from .choose import can_choose, choose
from .explained import Explained


class DAPPLE_OT_choose(Explained, bpy.types.Operator):
    """Take water and receivers from the selected objects: water lets light through, glass and metal cast by \
themselves, and the rest receives. The receivers are put in a collection of their own, beside those that they are in"""

    bl_idname = "dapple.choose"
    bl_label = "Use Selection"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def lacks(cls, context):
        return "" if can_choose(context) else "Select the water and the meshes that its light falls on"

    def execute(self, context):
        try:
            self.report({"INFO"}, choose(context))
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}
