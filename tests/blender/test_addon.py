"""Registration, settings, panels and the bake buttons."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import dapple  # noqa: E402
from dapple.addon.properties import _is_box  # noqa: E402
from dapple.operators.bake.progress import Preview, Waiting, clock  # noqa: E402
from dapple.operators.buttons import ops_attach, ops_bake  # noqa: E402
from dapple.operators.errors import DappleError  # noqa: E402

CLASSES = (
    "DappleSettings",
    "DappleObject",
    "DappleProgress",
    "DAPPLE_PT_bake",
    "DAPPLE_PT_scene",
    "DAPPLE_PT_casters",
    "DAPPLE_PT_influence",
    "DAPPLE_PT_quality",
    "DAPPLE_PT_output",
    "DAPPLE_PT_margin",
    "DAPPLE_PT_materials",
    "DAPPLE_PT_status",
)
OPERATORS = ("bake_frame", "bake_animation", "stop", "attach", "detach", "choose", "live_preview")
OPERATORS += ("show_status", "export", "chart", "lightmap_uvs")


def presence():
    """What of ours Blender knows."""
    known = [name for name in CLASSES if bpy.types.PropertyGroup.bl_rna_get_subclass_py(name)]
    known += [name for name in CLASSES if bpy.types.Panel.bl_rna_get_subclass_py(name)]
    known += [name for name in OPERATORS if name in dir(bpy.ops.dapple)]
    return known + ["Scene.dapple"] * hasattr(bpy.types.Scene, "dapple")


def test_registering_twice_works_and_leaves_nothing_behind():
    for _ in range(2):
        assert presence() == []
        dapple.register()
        assert set(presence()) == {*CLASSES, *OPERATORS, "Scene.dapple"}
        dapple.unregister()
    assert presence() == []


def test_command_line_command_comes_and_goes(empty_scene, monkeypatch):
    from dapple.addon import registration
    from dapple.operators import cli

    monkeypatch.setattr(cli, "main", lambda argv: len(argv))
    assert registration._command(["bake", "--frames", "1"]) == 3
    (handle,) = registration._commands
    dapple.unregister()
    try:
        with pytest.raises(ValueError):
            bpy.utils.unregister_cli_command(handle)
    finally:
        dapple.register()


def test_settings_start_as_documented(empty_scene):
    settings = empty_scene.dapple
    assert (settings.water, settings.receivers) == (None, None)
    assert (settings.method, settings.resolution, settings.padding) == ("auto", 512, 4)
    assert settings.tolerance == pytest.approx(0.01)
    assert (settings.use_scene_range, settings.frame_start, settings.frame_end) == (True, 1, 48)
    assert (settings.bounces, settings.volume, settings.culling) == (6, None, set())
    assert settings.output == "//caustics"


def test_settings_are_saved_with_the_file(empty_scene, tmp_path):
    pool(empty_scene)
    empty_scene.dapple.method = "conic_walk"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pool.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pool.blend"))
    settings = bpy.context.scene.dapple
    assert (settings.water.name, settings.receivers.name, settings.method) == ("Water", "Receivers", "conic_walk")


class Layout:
    """Stands in for UILayout: takes only what exists, and remembers it."""

    def __init__(self, seen):
        self.seen = seen
        self.enabled = True

    def prop(self, data, name, text=None, expand=False, translate=True):
        assert name in data.bl_rna.properties
        self.seen.append((name, self.enabled))

    def label(self, text, icon="NONE", translate=True):
        assert icon in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items

    def operator(self, idname, icon, depress=False):
        assert icon in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items
        self.seen.append((bpy.ops.dapple.__getattr__(idname.removeprefix("dapple.")).get_rna_type().name, self.enabled))

    def progress(self, factor, text, translate=True):
        assert 0 <= factor <= 1 and text

    def column(self, align=False, heading="", factor=0.0):
        return Layout(self.seen)

    row = split = column


def drawn():
    seen = []
    for name in CLASSES[3:]:
        panel = bpy.types.Panel.bl_rna_get_subclass_py(name)
        assert panel.bl_category == "Dapple"
        panel.draw(Drawn(panel, seen), bpy.context)
    return seen


class Drawn:
    """A panel while it is drawn."""

    def __init__(self, panel, seen):
        self.layout, self.panel = Layout(seen), panel

    def column(self):
        return self.panel.column(self)


def test_panels_show_every_setting_and_button(empty_scene):
    names = {name for name, _ in drawn()}
    settings = {p.identifier for p in empty_scene.dapple.bl_rna.properties} - {"rna_type", "name"}
    buttons = {"Bake Frame", "Bake Animation", "Live Preview", "Use Selection", "Attach to Materials", "Detach"}
    buttons |= {"Export Maps", "Chart Methods", "Make Lightmap UVs"}
    assert names == settings | buttons
    assert "Use Selection" not in dict(drawn_with_receivers(empty_scene))


def drawn_with_receivers(scene):
    pool(scene)
    return drawn()


def test_the_active_mesh_shows_whether_it_casts(empty_scene):
    pool(empty_scene)
    assert "caustics" not in dict(drawn())
    bpy.context.view_layer.objects.active = bpy.data.objects["Sun"]
    assert "caustics" not in dict(drawn())
    bpy.context.view_layer.objects.active = bpy.data.objects["Floor"]
    assert {("caustics", True), ("ior", True), ("abbe", True)} <= set(drawn())


def test_culling_waits_for_a_volume_which_is_a_cube(empty_scene):
    assert ("culling", False) in drawn()
    box = bpy.data.objects.new("Box", None)
    assert not _is_box(empty_scene.dapple, box)
    box.empty_display_type = "CUBE"
    assert _is_box(empty_scene.dapple, box)
    empty_scene.dapple.volume = box
    assert ("culling", True) in drawn()


def test_frame_range_is_greyed_while_the_scene_has_the_say(empty_scene):
    assert ("frame_start", False) in drawn()
    empty_scene.dapple.use_scene_range = False
    assert ("frame_start", True) in drawn()


def test_the_frame_range_that_shows_is_the_one_that_is_baked(empty_scene, monkeypatch):
    owners = {}
    monkeypatch.setattr(Layout, "prop", lambda self, data, name, **_: owners.update({name: data}))
    for owner, scenes in ((empty_scene, True), (empty_scene.dapple, False)):
        empty_scene.dapple.use_scene_range = scenes
        drawn()
        assert owners["frame_start"] == owners["frame_end"] == owner


def pool(scene):
    """Water over one receiver, in a nested collection, under a Sun."""
    receivers, inner = bpy.data.collections.new("Receivers"), bpy.data.collections.new("Inner")
    receivers.children.link(inner)
    scene.collection.children.link(receivers)
    quad(scene.collection, "Water", 1.0, 1.5)
    quad(inner, "Floor", 0.0, 1.0)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle = 1.0, 0.0
    scene.collection.objects.link(lamp)
    scene.dapple.water = bpy.data.objects["Water"]
    scene.dapple.receivers = receivers


def quad(collection, name, height, half):
    mesh = bpy.data.meshes.new(name)
    corners = [(-half, -half, height), (half, -half, height), (half, half, height), (-half, half, height)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    collection.objects.link(bpy.data.objects.new(name, mesh))


@pytest.mark.parametrize("name", ["bake_frame", "bake_animation", "attach"])
def test_buttons_say_why_they_are_greyed(name, empty_scene):
    button = getattr(bpy.ops.dapple, name)
    pool(empty_scene)
    assert button.poll()
    settings = empty_scene.dapple
    lacks_all = "receivers first" if name == "attach" else "Select the water"
    for lacking, reason in (("Floor", "no mesh"), ("receivers", "receivers first"), ("water", lacks_all)):
        if lacking == "Floor":
            bpy.data.objects.remove(bpy.data.objects["Floor"])
        else:
            setattr(settings, lacking, None)
        assert not button.poll()
        with pytest.raises(RuntimeError, match=reason):
            button()


def test_what_there_is_nothing_to_do_for_says_so(empty_scene, tmp_path):
    pool(empty_scene)
    empty_scene.dapple.output = str(tmp_path)
    for button, reason in (("detach", "No object shows its maps"), ("export", "Nothing is baked yet")):
        with pytest.raises(RuntimeError, match=reason):
            getattr(bpy.ops.dapple, button)()


def test_bake_frame_writes_the_light_of_flat_water(empty_scene, tmp_path):
    """Under an overhead sun all light but Fresnel's 2.04 % passes flat water."""
    pool(empty_scene)
    settings = empty_scene.dapple
    settings.output, settings.resolution = str(tmp_path), 16
    empty_scene.frame_set(7)
    assert bpy.ops.dapple.bake_frame() == {"FINISHED"}
    assert empty_scene.frame_current == 7
    assert [p.name for p in tmp_path.glob("*/*")] == ["caustics_0007.exr"]
    image = bpy.data.images.load(str(tmp_path / "Floor" / "caustics_0007.exr"))
    pixels = np.array(image.pixels[:]).reshape(16, 16, 4)[..., :3]
    expected = 1 - (0.333 / 2.333) ** 2
    assert pixels.mean() == pytest.approx(expected, rel=0.01)
    assert ((pixels / expected - 1) ** 2).mean() < settings.tolerance
    assert bpy.ops.dapple.attach() == {"FINISHED"}
    assert "dapple" in bpy.data.objects["Floor"].material_slots[0].material.node_tree.nodes["Dapple"]


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


@pytest.fixture
def ready(empty_scene):
    """A scene that can be baked, from frame 2 to 4, with absolute paths."""
    pool(empty_scene)
    empty_scene.dapple.output = bpy.app.tempdir
    empty_scene.frame_start, empty_scene.frame_end, empty_scene.frame_current = 2, 4, 3
    return empty_scene


def test_scripts_bake_to_the_end(ready, monkeypatch):
    log = []
    monkeypatch.setattr(ops_bake, "bake", fake_bake(log))
    assert bpy.ops.dapple.bake_animation() == {"FINISHED"}
    assert bpy.ops.dapple.bake_frame() == {"FINISHED"}
    assert log == [2, 3, 4, "closed", 3, "closed"]


def test_an_error_is_reported_as_its_sentence(ready, monkeypatch):
    monkeypatch.setattr(ops_bake, "bake", fake_bake([], fails_at=3))
    with pytest.raises(RuntimeError, match="Error: Object 'Water' is empty"):
        bpy.ops.dapple.bake_animation()


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


def press(monkeypatch, fails_at=None):
    """Invoke the button; return it, its context and the bake's log."""
    log, manager = [], Manager()
    monkeypatch.setattr(ops_bake, "bake", fake_bake(log, fails_at))
    monkeypatch.setattr(ops_bake, "refresh", lambda *maps: log.append(maps))
    monkeypatch.setattr(ops_bake, "supply", lambda *_: "")
    set_up = SimpleNamespace(dapple=SimpleNamespace(water="Water", receivers="Receivers"))
    context = SimpleNamespace(window="window", window_manager=manager, workspace=manager, scene=set_up)
    button = Button()
    assert button._start(context) == {"RUNNING_MODAL"}
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
    button._steps = iter([Waiting(1, 3, "frame 3: light", 75.0)])
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


def test_the_stop_button_is_greyed_until_there_is_something_to_stop(empty_scene):
    told = bpy.context.window_manager.dapple
    assert not bpy.ops.dapple.stop.poll()
    told.begin()
    assert bpy.ops.dapple.stop() == {"FINISHED"}
    assert told.stop
    told.end()
    assert not (told.running or told.stop)


def test_the_panel_shows_the_bake_that_runs(empty_scene):
    assert "Stop Baking" not in dict(drawn())
    bpy.context.window_manager.dapple.begin()
    assert "Stop Baking" in dict(drawn())
    bpy.context.window_manager.dapple.end()


def test_what_attaching_warns_of_is_said_last(ready, monkeypatch):
    monkeypatch.setattr(ops_attach, "attach", lambda *_: ["It shows a copy."])
    button = Button()
    assert ops_attach.DAPPLE_OT_attach.execute(button, bpy.context) == {"FINISHED"}
    assert [kind for kind, _ in button.reports] == ["INFO", "WARNING"]


@pytest.mark.parametrize(
    ("button", "reason"), [("DAPPLE_OT_bake_frame", "A bake is running"), ("DAPPLE_OT_chart", "being measured")]
)
def test_a_bake_waits_for_what_keeps_the_workers_busy(button, reason, ready):
    running = SimpleNamespace(modal_operators=[SimpleNamespace(bl_idname=button)])
    assert reason in ops_bake._is_busy(SimpleNamespace(windows=[running]))
    assert not ops_bake._is_busy(bpy.context.window_manager)
