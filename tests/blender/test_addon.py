"""Registration, and the settings that a scene keeps."""

import pytest

bpy = pytest.importorskip("bpy")

import dapple  # noqa: E402
from dapple.tests.blender.quad_pool import pool  # noqa: E402

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
    "DAPPLE_PT_status",
)
OPERATORS = ("bake_frame", "bake_animation", "stop", "attach", "detach", "choose", "live_preview")
OPERATORS += ("show_status", "export", "chart", "lightmap_uvs", "look_through")


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
