"""The button that makes the chart of the current frame: a worker measures, the interface stays free."""

from __future__ import annotations

import bpy

from ..bake.bake import request_from_scene
from ..buttons.explained import receivers_lacking
from ..buttons.stepping import Stepping
from .make import chart

_STOP_HELP = "Esc stops, and nothing is written"


class _Chart(Stepping):
    """Run the chart's iterator."""

    doing = f"measuring. {_STOP_HELP}"
    _paths, _seen = (), False

    @classmethod
    def lacks(cls, context):
        busy = "A bake is running: its workers would disturb the clock"
        return receivers_lacking(context.scene) or (busy if context.window_manager.dapple.running else "")

    def begin(self, context, wait=None):
        self._paths, self._seen = (), wait is not None
        request = request_from_scene(context.scene, frames=(context.scene.frame_current,))
        self.steps = self._keep(chart(context, request, wait=0.2 if wait is None else wait))

    def _keep(self, steps):
        """The steps, and what they lead to in `_paths`."""
        self._paths = yield from steps

    def tell(self, context, step):
        if step and context.window_manager.dapple.tell(0.0, step):
            context.workspace.status_text_set(f"Dapple: {step}. {_STOP_HELP}")

    def finish(self):
        if self._seen:
            self._show(self._paths[0])
        self.report({"INFO"}, f"The chart is in {self._paths[0]}")
        return {"FINISHED"}

    def stopped(self):
        return "Stopped: no chart is written"

    def _show(self, path):
        """Open the picture with whatever the system opens pictures with."""
        bpy.ops.wm.path_open(filepath=str(path))


class DAPPLE_OT_chart(_Chart, bpy.types.Operator):
    """Measure every method on the current frame and draw how good it is against how long it takes. \
A few minutes; Esc stops, and nothing is written"""

    bl_idname = "dapple.chart"
    bl_label = "Chart Methods"
