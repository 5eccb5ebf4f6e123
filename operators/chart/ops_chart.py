"""The button that makes the chart of the current frame: a worker measures, the interface stays free."""

from __future__ import annotations

import bpy

from ..bake.bake import request_from_scene
from ..buttons.ops_bake import why_not
from ..errors import DappleError
from .make import chart

_TICK = 0.1


class _Chart:
    """Run the chart's iterator."""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        reason = why_not(context.scene)
        if not reason and context.window_manager.dapple.running:
            reason = "A bake is running: its workers would disturb the clock"
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def execute(self, context):
        try:
            steps = self._begin(context)
            while True:
                next(steps)
        except StopIteration as end:
            return self._finish(end.value)
        except DappleError as error:
            return self._fail(error)

    def invoke(self, context, _event):
        # In the background no timer fires.
        return self.execute(context) if bpy.app.background else self.start(context)

    def start(self, context):
        """Begin in a window."""
        try:
            self._steps = self._begin(context, 0.0)
        except DappleError as error:
            return self._fail(error)
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        manager.modal_handler_add(self)
        manager.dapple.begin()
        context.workspace.status_text_set("Dapple: measuring. Esc stops, and nothing is written")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" or context.window_manager.dapple.stop:
            self.cancel(context)
            self.report({"WARNING"}, "Stopped: no chart is written")
            return {"CANCELLED"}
        return self._step(context) if event.type == "TIMER" else {"PASS_THROUGH"}

    def _step(self, context):
        try:
            sentence = next(self._steps)
        except StopIteration as end:
            self.cancel(context)
            self._show(end.value[0])
            return self._finish(end.value)
        except DappleError as error:
            self.cancel(context)
            return self._fail(error)
        except BaseException:
            self.cancel(context)
            raise
        if sentence and context.window_manager.dapple.tell(0.0, sentence):
            context.workspace.status_text_set(f"Dapple: {sentence}. Esc stops, and nothing is written")
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """End the worker and give the window back; Blender calls it on quitting too."""
        self._steps.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.dapple.end()
        context.workspace.status_text_set(None)

    def _begin(self, context, wait=0.2):
        request = request_from_scene(context.scene, frames=(context.scene.frame_current,))
        return chart(context, request, wait=wait)

    def _finish(self, paths):
        self.report({"INFO"}, f"The chart is in {paths[0]}")
        return {"FINISHED"}

    def _fail(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def _show(self, path):
        """Open the picture with whatever the system opens pictures with."""
        bpy.ops.wm.path_open(filepath=str(path))


class DAPPLE_OT_chart(_Chart, bpy.types.Operator):
    """Measure every method on the current frame and draw how good it is against how long it takes. \
A few minutes; Esc stops, and nothing is written"""

    bl_idname = "dapple.chart"
    bl_label = "Chart Methods"
