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
from ..show import live
from ..show.attach import refresh
from .choose import choose, wants_choice
from .explained import Explained, choice_lacking, workers_busy
from .ops_choose import DAPPLE_OT_choose
from .ops_uvs import DAPPLE_OT_lightmap_uvs
from .stepping import Stepping

_STOP_HELP = "Esc stops and keeps the finished frames"


class _Bake(Stepping):
    """Run the bake's iterator; a subclass says which frames."""

    tick = 0.02
    doing = f"baking. {_STOP_HELP}"
    previews = False

    @classmethod
    def lacks(cls, context):
        return choice_lacking(context) or workers_busy(context.window_manager)

    def request(self, scene):
        raise NotImplementedError

    def begin(self, context, wait=None):
        self._last, self._warnings, self._rough, self._folder = None, {}, False, None
        live.stop(context)
        if wants_choice(context.scene):
            self._change(choose(context), DAPPLE_OT_choose)
        self._request = self.request(context.scene)
        made = supply(context, self._request)
        if made:
            self._change(made, DAPPLE_OT_lightmap_uvs)
        if self.previews and wait is not None:
            self._folder = tempfile.TemporaryDirectory(prefix="dapple-")
        self.steps = bake(context, self._request, self._folder and Path(self._folder.name), wait)

    def start(self, context):
        ends = super().start(context)
        if ends == {"RUNNING_MODAL"}:
            context.window_manager.progress_begin(0, 1)
        return ends

    def cancel(self, context):
        context.window_manager.progress_end()
        super().cancel(context)

    def _change(self, sentence, operator):
        """Say what was changed in the file, as if a button had done it: the bake itself leaves nothing to undo."""
        self.report({"INFO"}, sentence)
        if bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message=operator.bl_label)

    def tell(self, context, step):
        if isinstance(step, Preview):
            self._rough = True
            refresh(self._request.receivers, step.folder)
            text = "a first picture is shown, a better one comes"
        elif isinstance(step, Waiting):
            left = "" if step.left is None else f"about {clock(step.left)} left"
            text = "; ".join(filter(None, (f"{step.done} of {step.total} frames", step.message, left)))
        else:
            self.take(step)
            self._show()
            context.window_manager.progress_update(step.done / step.total)
            # Not its message: a sentence that comes and goes would move what is below it; Last Bake has it all.
            text = f"{step.done} of {step.total} frames; frame {step.frame} is done"
        part = (self._last.done / self._last.total) if self._last else 0.0
        if context.window_manager.dapple.tell(part, text):
            context.workspace.status_text_set(f"Dapple: {text}. {_STOP_HELP}")

    def take(self, progress):
        self._last = progress
        self._warnings.update(dict.fromkeys(progress.warnings))

    def clear(self, context):
        if self._rough:
            with contextlib.suppress(DappleError):  # there may be no better maps to go back to
                refresh(self._request.receivers, self._request.out)
        if self._folder:
            self._folder.cleanup()

    def finish(self):
        self._show()
        self.report({"INFO"}, self._last.message)
        # Last, for the status bar shows the last report only.
        for warning in self._warnings:
            self.report({"WARNING"}, warning)
        return {"FINISHED"}

    def stopped(self):
        self._show()
        return f"Stopped: {self._last.done if self._last else 0} finished frame(s) are kept"

    def fail(self, error):
        self._show()
        return super().fail(error)

    def _show(self):
        """Let receivers that show their maps show the new ones."""
        if self._last:
            refresh(self._request.receivers, self._request.out)


class DAPPLE_OT_stop(Explained, bpy.types.Operator):
    """Stop the bake that is running, and keep the finished frames"""

    bl_idname = "dapple.stop"
    bl_label = "Stop Baking"

    @classmethod
    def lacks(cls, context):
        return "" if context.window_manager.dapple.running else "No bake is running"

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
