"""The live preview: shown while it is on, in memory only, and gone without a trace."""

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.show import live
from dapple.operators.show.attach import attach
from dapple.operators.show.attach_slots import SLOTS
from dapple.tests.blender.attach_scene import state
from dapple.tests.blender.small_pool import build_pool, files_in, solve_by_height, use_solver


@pytest.fixture
def pool(empty_scene, tmp_path, monkeypatch):
    """The small pool, solved by the height of its water."""
    build_pool(empty_scene, tmp_path / "out")
    use_solver(monkeypatch, solve_by_height)
    yield empty_scene
    live.stop(bpy.context)


def shown():
    """The image that the floor's material shows."""
    nodes = bpy.data.objects["Floor"].material_slots[0].material.node_tree.nodes
    return nodes["Dapple Irradiance"].image


def mean(image):
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, 4)[:, :3].mean()


def come_to(scene, frame):
    """Change the frame; timers never fire in the background, so the tick that is due is made here."""
    scene.frame_set(frame)
    assert bpy.app.timers.is_registered(live._tick)
    bpy.app.timers.unregister(live._tick)
    live._tick()


def test_each_frame_is_shown_and_nothing_is_written(pool, tmp_path):
    before = state()
    assert bpy.ops.dapple.live_preview() == {"FINISHED"}
    assert tuple(shown().size) == (live.RESOLUTION, live.RESOLUTION)
    assert mean(shown()) == pytest.approx(1.0)
    come_to(pool, 3)
    assert mean(shown()) == pytest.approx(1.2)
    assert files_in(tmp_path) == []
    assert bpy.ops.dapple.live_preview() == {"FINISHED"}
    assert state() == before
    pool.frame_set(2)
    assert not bpy.app.timers.is_registered(live._tick)


def test_maps_that_were_shown_are_shown_again(pool, tmp_path):
    list(bake(bpy.context, request_from_scene(pool)))
    attach(bpy.context, ["Floor"], tmp_path / "out")
    before = state()
    live.start(bpy.context)
    assert shown().source == "GENERATED"
    live.stop(bpy.context)
    assert state() == before
    assert shown().source == "SEQUENCE"


def test_a_saved_file_holds_nothing_of_it(pool, tmp_path):
    live.start(bpy.context)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pool.blend"))
    bpy.app.timers.unregister(live._tick)
    live._tick()
    assert mean(shown()) == pytest.approx(1.0)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "pool.blend"))
    assert not live.is_on()
    assert len(bpy.data.images) == 0 and not any("Dapple" in material.name for material in bpy.data.materials)
    assert not any(key in obj for obj in bpy.data.objects for key in (live.LIVE, SLOTS))


def test_a_bake_and_a_detach_end_it(pool):
    for press in (bpy.ops.dapple.bake_frame, bpy.ops.dapple.detach):
        live.start(bpy.context)
        press()
        assert not live.is_on()
        assert not any(live.LIVE in image for image in bpy.data.images)


def test_what_cannot_be_baked_is_said_and_the_preview_goes_on(pool):
    live.start(bpy.context)
    sun = bpy.data.objects["Sun"]
    sun.hide_render = True
    come_to(pool, 2)
    assert "no lamp" in live.trouble()
    sun.hide_render = False
    come_to(pool, 3)
    assert live.trouble() == ""
    assert mean(shown()) == pytest.approx(1.2)


def test_it_comes_back_after_an_undo_took_it_off(pool):
    live.start(bpy.context)
    # As an undo would leave it: the nodes gone, the switch still on.
    live._hide(bpy.context)
    come_to(pool, 2)
    assert mean(shown()) == pytest.approx(1.1)


def test_switch_says_what_it_lacks(empty_scene):
    with pytest.raises(RuntimeError, match="Select the water"):
        bpy.ops.dapple.live_preview()


def test_selection_is_enough(pool):
    pool.dapple.water = pool.dapple.receivers = None
    for obj in bpy.data.objects:
        obj.select_set(obj.type == "MESH")
    floor = bpy.data.objects["Floor"].data
    floor.uv_layers.remove(floor.uv_layers[0])
    assert bpy.ops.dapple.live_preview() == {"FINISHED"}
    assert pool.dapple.water.name == "Water"
    assert mean(shown()) > 0.5


def test_what_the_kernels_refuse_is_a_sentence(pool):
    def refuse(*_):
        raise ValueError("the water does not tile")

    with pytest.MonkeyPatch.context() as patch:
        use_solver(patch, refuse)
        with pytest.raises(RuntimeError, match="Error: the water does not tile"):
            bpy.ops.dapple.live_preview()
    assert not live.is_on() and len(bpy.data.images) == 0
