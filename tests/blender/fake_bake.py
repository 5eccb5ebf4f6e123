"""A bake that solves nothing, and a window that shows nothing: what they are told is written down."""

from dataclasses import dataclass
from types import SimpleNamespace

from dapple.operators.bake.progress import Preview
from dapple.operators.buttons import ops_bake
from dapple.operators.errors import DappleError


@dataclass
class Progress:
    """What the bake yields."""

    frame: int
    done: int
    total: int
    message: str
    warnings: tuple[str, ...] = ("The water is a lake.",)


def fake_bake(log, fails_at=None):
    """A stand-in for the bake that writes down what happens to it."""

    def bake(_context, request, previews=None, wait=None):
        try:
            if previews:
                yield Preview(request.frames[0], previews)
            for done, frame in enumerate(request.frames, 1):
                if frame == fails_at:
                    raise DappleError("Object 'Water' is empty.")
                log.append(frame)
                yield Progress(frame, done, len(request.frames), f"Frame {frame}.")
        finally:
            log.append("closed")

    return bake


class Told:
    """Stands in for the window manager's own settings."""

    running = stop = False

    def begin(self):
        self.running = True

    def tell(self, part, text):
        self.part, self.text = part, text
        return True

    def end(self):
        self.running = False


class Manager:
    """Stands in for the window manager and the workspace: remembers what is still on."""

    def __init__(self):
        self.on = set()
        self.shown = []
        self.windows = ()
        self.dapple = Told()

    def event_timer_add(self, _seconds, window):
        self.on.add("timer")
        return "timer"

    def event_timer_remove(self, timer):
        self.on.remove(timer)

    def progress_begin(self, _low, _high):
        self.on.add("progress")

    def progress_update(self, value):
        self.shown.append(value)

    def progress_end(self):
        self.on.remove("progress")

    def modal_handler_add(self, _operator):
        pass

    def status_text_set(self, text):
        (self.on.add if text else self.on.discard)("status")


class Button(ops_bake._Bake):
    """The operator without Blender's window behind it."""

    def __init__(self):
        self.reports = []

    def request(self, scene):
        return SimpleNamespace(frames=(2, 3, 4), receivers=("Floor",), out="maps")

    def report(self, kind, text):
        self.reports.append((*kind, text))
