"""The bake buttons in a window: what is shown at each tick, and how they end."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.bake.progress import Waiting, clock  # noqa: E402
from dapple.operators.buttons import ops_bake  # noqa: E402
from dapple.tests.blender.fake_bake import Button, Manager, fake_bake  # noqa: E402


def press(monkeypatch, fails_at=None):
    """Invoke the button; return it, its context and the bake's log."""
    log, manager = [], Manager()
    monkeypatch.setattr(ops_bake, "bake", fake_bake(log, fails_at))
    monkeypatch.setattr(ops_bake, "refresh", lambda *maps: log.append(maps))
    monkeypatch.setattr(ops_bake, "supply", lambda *_: "")
    set_up = SimpleNamespace(dapple=SimpleNamespace(water="Water", receivers="Receivers"))
    context = SimpleNamespace(window="window", window_manager=manager, workspace=manager, scene=set_up)
    button = Button()
    assert button.start(context) == {"RUNNING_MODAL"}
    assert manager.on == {"timer", "progress", "status"}
    return button, context, log


def event(kind):
    return SimpleNamespace(type=kind)


def test_the_window_takes_what_is_done_at_each_tick_and_shows_it(monkeypatch):
    button, context, log = press(monkeypatch)
    assert context.window_manager.dapple.running
    for frame in (2, 3, 4):
        assert button.modal(context, event("TIMER")) == {"PASS_THROUGH"}
        assert log[-2:] == [frame, (("Floor",), "maps")]
        assert context.window_manager.dapple.text == f"{frame - 1} of 3 frames; frame {frame} is done"
    assert button.modal(context, event("TIMER")) == {"FINISHED"}
    assert log[-2:] == ["closed", (("Floor",), "maps")]
    assert context.window_manager.shown == pytest.approx([1 / 3, 2 / 3, 1])
    assert context.window_manager.on == set()
    assert not context.window_manager.dapple.running
    assert button.reports == [("INFO", "Frame 4."), ("WARNING", "The water is a lake.")]


def test_while_workers_work_the_window_says_what_they_are_at(monkeypatch):
    button, context, _ = press(monkeypatch)
    button.modal(context, event("TIMER"))
    button.steps = iter([Waiting(1, 3, "frame 3: light", 75.0)])
    assert button.modal(context, event("TIMER")) == {"PASS_THROUGH"}
    told = context.window_manager.dapple
    assert told.part == pytest.approx(1 / 3)
    assert told.text == "1 of 3 frames; frame 3: light; about 1:15 min left"


@pytest.mark.parametrize(("seconds", "text"), [(8.4, "8 s"), (60, "1:00 min"), (3599.7, "1:00 h"), (7380, "2:03 h")])
def test_time_that_is_left_reads_as_people_say_it(seconds, text):
    assert clock(seconds) == text


def test_a_first_picture_shows_from_a_folder_of_its_own_that_goes_again(monkeypatch):
    monkeypatch.setattr(Button, "previews", True)
    button, context, log = press(monkeypatch)
    button.modal(context, event("TIMER"))
    ((names, folder),) = log
    assert names == ("Floor",)
    assert folder.is_dir()
    assert context.window_manager.shown == []
    button.modal(context, event("TIMER"))
    assert button.modal(context, event("ESC")) == {"CANCELLED"}
    assert log[1:4] == [2, (("Floor",), "maps"), "closed"]
    assert log[-1] == (("Floor",), "maps")
    assert not folder.exists()


def test_escape_after_the_first_picture_goes_back_to_the_maps(monkeypatch):
    monkeypatch.setattr(Button, "previews", True)
    button, context, log = press(monkeypatch)
    button.modal(context, event("TIMER"))
    assert button.modal(context, event("ESC")) == {"CANCELLED"}
    assert log[1:] == ["closed", (("Floor",), "maps")]
    assert context.window_manager.on == set()


def test_escape_before_the_first_frame_changes_nothing(monkeypatch):
    button, context, log = press(monkeypatch)
    assert button.modal(context, event("ESC")) == {"CANCELLED"}
    assert log == []
    assert context.window_manager.on == set()


@pytest.mark.parametrize("how", ["Esc", "the button"])
def test_stopping_closes_the_bake_and_keeps_what_is_done(monkeypatch, how):
    button, context, log = press(monkeypatch)
    button.modal(context, event("TIMER"))
    context.window_manager.dapple.stop = how == "the button"
    assert button.modal(context, event("ESC" if how == "Esc" else "TIMER")) == {"CANCELLED"}
    assert log == [2, (("Floor",), "maps"), "closed", (("Floor",), "maps")]
    assert context.window_manager.on == set()
    assert button.reports == [("WARNING", "Stopped: 1 finished frame(s) are kept")]


def test_an_error_in_a_frame_gives_the_window_back(monkeypatch):
    button, context, log = press(monkeypatch, fails_at=3)
    button.modal(context, event("TIMER"))
    assert button.modal(context, event("TIMER")) == {"CANCELLED"}
    assert log[-2:] == ["closed", (("Floor",), "maps")]
    assert context.window_manager.on == set()
    assert button.reports == [("ERROR", "Object 'Water' is empty.")]


def test_all_but_escape_reaches_the_interface(monkeypatch):
    button, context, _ = press(monkeypatch)
    for kind in ("Z", "LEFTMOUSE", "MOUSEMOVE", "WHEELUPMOUSE"):
        assert button.modal(context, event(kind)) == {"PASS_THROUGH"}
