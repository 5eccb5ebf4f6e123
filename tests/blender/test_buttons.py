"""Buttons as scripts press them, and the reasons for which they are greyed."""

from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.buttons import explained, ops_attach, ops_bake  # noqa: E402
from dapple.tests.blender.fake_bake import Button, fake_bake  # noqa: E402
from dapple.tests.blender.quad_pool import pool  # noqa: E402


@pytest.fixture
def ready(empty_scene):
    """A scene that can be baked, from frame 2 to 4, with absolute paths."""
    pool(empty_scene)
    empty_scene.dapple.output = bpy.app.tempdir
    empty_scene.frame_start, empty_scene.frame_end, empty_scene.frame_current = 2, 4, 3
    return empty_scene


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


def test_the_stop_button_is_greyed_until_there_is_something_to_stop(empty_scene):
    told = bpy.context.window_manager.dapple
    assert not bpy.ops.dapple.stop.poll()
    told.begin()
    assert bpy.ops.dapple.stop() == {"FINISHED"}
    assert told.stop
    told.end()
    assert not (told.running or told.stop)


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
    assert reason in explained.workers_busy(SimpleNamespace(windows=[running]))
    assert not explained.workers_busy(bpy.context.window_manager)
