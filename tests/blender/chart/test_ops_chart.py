"""The button in a window: what it says, shows and gives back, however it ends."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.chart import ops_chart  # noqa: E402
from dapple.operators.errors import DappleError  # noqa: E402
from dapple.tests.blender.small_pool import build_pool  # noqa: E402


class Window:
    """Stands in for the window manager and the workspace: remembers what is still on."""

    def __init__(self):
        self.on, self.stop, self.running = set(), False, False

    def event_timer_add(self, _seconds, window):
        self.on.add("timer")
        return "timer"

    def event_timer_remove(self, timer):
        self.on.remove(timer)

    def modal_handler_add(self, _operator):
        pass

    def status_text_set(self, text):
        (self.on.add if text else self.on.discard)("status")
        self.text = text or self.text

    def begin(self):
        self.on.add("progress")

    def tell(self, _part, _text):
        return True

    def end(self):
        self.on.remove("progress")

    @property
    def dapple(self):
        return self


class Button(ops_chart._Chart):
    """The operator without Blender's window behind it."""

    def __init__(self):
        self.said, self.shown = [], []

    def report(self, kind, text):
        self.said.append((*kind, text))

    def _show(self, path):
        self.shown.append(path)


@pytest.fixture
def start(empty_scene, tmp_path, monkeypatch):
    """Press the button in a window, with steps in the place of the chart's; gives it, its context and a log."""
    build_pool(empty_scene, tmp_path)
    log = []

    def press(*steps):
        def chart(context, request, wait):
            log.append((request.frames, wait))
            try:
                for step in steps:
                    if isinstance(step, Exception):
                        raise step
                    yield step
                return ["a/chart.png"]
            finally:
                log.append("closed")

        monkeypatch.setattr(ops_chart, "chart", chart)
        window, button = Window(), Button()
        context = SimpleNamespace(window=window, window_manager=window, workspace=window, scene=empty_scene)
        assert button.start(context) == {"RUNNING_MODAL"}
        assert window.on == {"timer", "status", "progress"}
        return button, context, log

    return press


def event(kind):
    return SimpleNamespace(type=kind)


def test_to_the_end(start):
    button, context, log = start("flat: 1 s", "")
    for _ in range(2):
        assert button.modal(context, event("TIMER")) == {"PASS_THROUGH"}
    assert "flat: 1 s" in context.workspace.text
    assert button.modal(context, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert button.modal(context, event("TIMER")) == {"FINISHED"}
    assert button.shown == ["a/chart.png"]
    assert button.said == [("INFO", "The chart is in a/chart.png")]
    assert log == [((1,), 0), "closed"]
    assert context.window.on == set()


@pytest.mark.parametrize("how", ["Esc", "Stop"])
def test_stopped(start, how):
    button, context, log = start("flat: 1 s", "more")
    button.modal(context, event("TIMER"))
    context.window.stop = how == "Stop"
    assert button.modal(context, event("ESC" if how == "Esc" else "TIMER")) == {"CANCELLED"}
    assert log[-1] == "closed"
    assert button.said == [("WARNING", "Stopped: no chart is written")]
    assert (button.shown, context.window.on) == ([], set())


@pytest.mark.parametrize("error", [DappleError("Frame 1: there is no lamp."), RuntimeError("a fault")])
def test_errors_give_the_window_back(start, error):
    button, context, _ = start(error)
    if isinstance(error, DappleError):
        assert button.modal(context, event("TIMER")) == {"CANCELLED"}
        assert button.said == [("ERROR", "Frame 1: there is no lamp.")]
    else:
        with pytest.raises(RuntimeError):
            button.modal(context, event("TIMER"))
    assert context.window.on == set()
