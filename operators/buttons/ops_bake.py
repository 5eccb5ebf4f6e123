"""The two bake buttons: one iterator, run to its end by scripts and step by step by the interface.

Other processes solve, so that the interface stays free for all but the reading of a frame. What is edited meanwhile
counts for the frames that are not read yet; the next bake mends the others, and only those.

Receivers that show their maps show rough ones of a single frame while it is being solved: these lie in a folder of
their own, so that whatever happens the maps on disk are whole and good.
"""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path

import bpy

from ..bake.bake import bake, request_from_scene
from ..bake.progress import Preview, Waiting, clock
from ..errors import DappleError
from ..read.lightmap_uvs import supply
from ..read.receivers import can_receive
from ..show import live
from ..show.attach import refresh
from .choose import can_choose, choose, flagged_receivers, wants_choice
from .ops_choose import DAPPLE_OT_choose
from .ops_uvs import DAPPLE_OT_lightmap_uvs

_TICK = 0.02  # s between looks at what the workers have said
_STOP_HELP = "Esc stops and keeps the finished frames"


def why_not(scene) -> str:
    """Say what a bake of `scene` still lacks, as a sentence for a tooltip; empty if nothing."""
    settings = scene.dapple
    if settings.receivers is None:
        return "" if flagged_receivers(scene) else "Pick the collection of receivers first"
    if not any(can_receive(o) and o != settings.water for o in settings.receivers.all_objects):
        return "The collection of receivers holds no mesh but the water"
    return ""


def why_not_yet(context) -> str:
    """As `why_not`, for a button that can take water and receivers from the selection."""
    if not wants_choice(context.scene):
        return why_not(context.scene)
    return "" if can_choose(context) else "Select the water and the meshes that its light falls on, or pick them below"


def _is_busy(window_manager) -> str:
    """Say what keeps the workers busy; empty if nothing."""
    running = {operator.bl_idname for window in window_manager.windows for operator in window.modal_operators}
    if "DAPPLE_OT_chart" in running:
        return "Methods are being measured: press Esc to stop that"
    if running & {"DAPPLE_OT_bake_frame", "DAPPLE_OT_bake_animation"}:
        return "A bake is running: press Esc to stop it"
    return ""


class _Bake:
    """Run the bake's iterator; a subclass says which frames."""

    bl_options = {"REGISTER"}
    previews = False

    @classmethod
    def poll(cls, context):
        reason = why_not_yet(context) or _is_busy(context.window_manager)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def request(self, scene):
        raise NotImplementedError

    def execute(self, context):
        try:
            self._begin(context)
            for progress in self._steps:
                self._take(progress)
        except DappleError as error:
            return self._fail(error)
        return self._finish()

    def invoke(self, context, _event):
        # In the background no timer fires.
        return self.execute(context) if bpy.app.background else self._start(context)

    def _begin(self, context, folder=None, wait=None):
        self._last, self._warnings, self._rough = None, {}, False
        live.stop(context)
        if wants_choice(context.scene):
            self.report({"INFO"}, choose(context))
            # The bake itself changes nothing that could be undone.
            if bpy.ops.ed.undo_push.poll():
                bpy.ops.ed.undo_push(message=DAPPLE_OT_choose.bl_label)
        self._request = self.request(context.scene)
        made = supply(context, self._request)
        if made:
            self.report({"INFO"}, made)
            if bpy.ops.ed.undo_push.poll():
                bpy.ops.ed.undo_push(message=DAPPLE_OT_lightmap_uvs.bl_label)
        self._steps = bake(context, self._request, folder, wait)

    def _start(self, context):
        self._folder = tempfile.TemporaryDirectory(prefix="dapple-")
        try:
            self._begin(context, Path(self._folder.name) if self.previews else None, wait=0)
        except DappleError as error:
            self._folder.cleanup()
            return self._fail(error)
        manager = context.window_manager
        self._timer = manager.event_timer_add(_TICK, window=context.window)
        manager.progress_begin(0, 1)
        manager.modal_handler_add(self)
        manager.dapple.begin()
        context.workspace.status_text_set(f"Dapple: baking. {_STOP_HELP}")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" or context.window_manager.dapple.stop:
            self.cancel(context)
            self._show()
            done = self._last.done if self._last else 0
            self.report({"WARNING"}, f"Stopped: {done} finished frame(s) are kept")
            return {"CANCELLED"}
        return self._step(context) if event.type == "TIMER" else {"PASS_THROUGH"}

    def _step(self, context):
        try:
            self._tell(context, next(self._steps))
        except StopIteration:
            self.cancel(context)
            return self._finish()
        except DappleError as error:
            self.cancel(context)
            return self._fail(error)
        except BaseException:
            self.cancel(context)
            raise
        return {"PASS_THROUGH"}

    def _tell(self, context, step):
        """Show in the window what the bake said."""
        if isinstance(step, Preview):
            self._rough = True
            refresh(self._request.receivers, step.folder)
            text = "a first picture is shown, a better one comes"
        elif isinstance(step, Waiting):
            left = "" if step.left is None else f"about {clock(step.left)} left"
            text = "; ".join(filter(None, (f"{step.done} of {step.total} frames", step.message, left)))
        else:
            self._take(step)
            self._show()
            context.window_manager.progress_update(step.done / step.total)
            # Not its message: a sentence that comes and goes would move what is below it; Last Bake has it all.
            text = f"{step.done} of {step.total} frames; frame {step.frame} is done"
        part = (self._last.done / self._last.total) if self._last else 0.0
        if context.window_manager.dapple.tell(part, text):
            context.workspace.status_text_set(f"Dapple: {text}. {_STOP_HELP}")

    def cancel(self, context):
        """Let the iterator clean up behind itself, and give the window back; Blender calls it on quitting too."""
        self._steps.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.window_manager.dapple.end()
        context.workspace.status_text_set(None)
        if self._rough:
            with contextlib.suppress(DappleError):  # there may be no better maps to go back to
                refresh(self._request.receivers, self._request.out)
        self._folder.cleanup()

    def _take(self, progress):
        self._last = progress
        self._warnings.update(dict.fromkeys(progress.warnings))

    def _finish(self):
        self._show()
        self.report({"INFO"}, self._last.message)
        # Last, for the status bar shows the last report only.
        for warning in self._warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def _fail(self, error):
        self._show()
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def _show(self):
        """Let receivers that show their maps show the new ones."""
        if self._last:
            refresh(self._request.receivers, self._request.out)


class DAPPLE_OT_stop(bpy.types.Operator):
    """Stop the bake that is running, and keep the finished frames"""

    bl_idname = "dapple.stop"
    bl_label = "Stop Baking"

    @classmethod
    def poll(cls, context):
        if not context.window_manager.dapple.running:
            cls.poll_message_set("No bake is running")
            return False
        return True

    def execute(self, context):
        context.window_manager.dapple.stop = True
        return {"FINISHED"}


class DAPPLE_OT_bake_frame(_Bake, bpy.types.Operator):
    """Bake the caustics of the current frame"""

    bl_idname = "dapple.bake_frame"
    bl_label = "Bake Frame"
    previews = True

    def request(self, scene):
        return request_from_scene(scene, frames=(scene.frame_current,))


class DAPPLE_OT_bake_animation(_Bake, bpy.types.Operator):
    """Bake the caustics of every frame in the range. Esc stops and keeps the finished frames"""

    bl_idname = "dapple.bake_animation"
    bl_label = "Bake Animation"

    def request(self, scene):
        return request_from_scene(scene)
