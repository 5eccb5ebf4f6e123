"""A button whose work is an iterator: run to its end by scripts, and step by step, at ticks of a timer, in a window.

Other processes do the work, so that the interface stays free; Esc and Stop close the iterator, which ends them.
"""

from __future__ import annotations

import bpy

from ..errors import DappleError
from .explained import Explained


class Stepping(Explained):
    """The run of `self.steps`. A subclass begins it, and says what its steps mean."""

    bl_options = {"REGISTER"}
    tick = 0.1  # s between looks at what is new
    doing = ""  # for the status bar, with what Esc does

    def begin(self, context, wait=None):
        """Set `self.steps`; wait: None for a script, which may be kept waiting, else 0. Raises DappleError."""
        raise NotImplementedError

    def take(self, step):
        """Take note of a step, in a script."""

    def tell(self, context, step):
        """Take note of a step, in a window, and show it there."""
        raise NotImplementedError

    def finish(self):
        """Report that all is done; returns what an operator returns."""
        raise NotImplementedError

    def stopped(self) -> str:
        """Say what a person who stops it is left with."""
        raise NotImplementedError

    def clear(self, context):
        """Put away what `begin` made; after the end, however that came."""

    def execute(self, context):
        try:
            self.begin(context)
            for step in self.steps:
                self.take(step)
        except DappleError as error:
            return self.fail(error)
        finally:
            self.clear(context)
        return self.finish()

    def invoke(self, context, _event):
        # In the background no timer fires.
        return self.execute(context) if bpy.app.background else self.start(context)

    def start(self, context):
        """Begin in a window."""
        try:
            self.begin(context, 0)
        except DappleError as error:
            self.clear(context)
            return self.fail(error)
        manager = context.window_manager
        self.timer = manager.event_timer_add(self.tick, window=context.window)
        manager.modal_handler_add(self)
        manager.dapple.begin()
        context.workspace.status_text_set(f"Dapple: {self.doing}")
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" or context.window_manager.dapple.stop:
            self.cancel(context)
            self.report({"WARNING"}, self.stopped())
            return {"CANCELLED"}
        return self._step(context) if event.type == "TIMER" else {"PASS_THROUGH"}

    def _step(self, context):
        try:
            self.tell(context, next(self.steps))
        except StopIteration:
            self.cancel(context)
            return self.finish()
        except DappleError as error:
            self.cancel(context)
            return self.fail(error)
        except BaseException:
            self.cancel(context)
            raise
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Let the iterator clean up behind itself, and give the window back; Blender calls it on quitting too."""
        self.steps.close()
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.dapple.end()
        context.workspace.status_text_set(None)
        self.clear(context)

    def fail(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}
