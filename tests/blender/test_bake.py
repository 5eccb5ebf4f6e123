"""A bake writes what was solved, frame by frame, and what was baked before stays."""

import subprocess
import sys
from dataclasses import replace

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import (
    HALF,
    add_grid,
    build_pool,
    files_in,
    record,
    run,
    solve_by_height,
    use_solver,
)


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def test_request_says_what_the_scene_says(pool, out):
    below = bpy.data.collections.new("Below")
    pool.dapple.receivers.children.link(below)
    add_grid("Basin", -1.0, below)
    pool.dapple.receivers.objects.link(pool.dapple.water)
    pool.dapple.receivers.objects.link(bpy.data.objects["Sun"])
    pool.dapple.method, pool.dapple.tolerance, pool.dapple.padding = "conic_walk", 0.3, 7
    request = request_from_scene(pool)
    assert request.water == ("Water",)
    assert request.receivers == ("Basin", "Floor")
    assert request.frames == (1, 2, 3)
    assert request.out == out
    settings = request.settings
    assert (settings.method, settings.resolution, settings.padding) == ("conic_walk", 16, 7)
    assert settings.tolerance == 0.3
    pool.dapple.use_scene_range, pool.dapple.frame_start, pool.dapple.frame_end = False, 7, 8
    assert request_from_scene(pool).frames == (7, 8)


def test_output_is_relative_to_the_file(pool, tmp_path):
    pool.dapple.output = "//maps"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "pool.blend"))
    assert request_from_scene(bpy.context.scene).out == tmp_path / "maps"


def test_each_frame_is_that_frame(pool, out):
    pool.frame_set(2)
    progress = run(pool)
    assert [(p.frame, p.done, p.total) for p in progress] == [(1, 1, 3), (2, 2, 3), (3, 3, 3)]
    assert "by_height" in progress[0].message
    assert "75.0% received, 25.0% lost" in progress[0].message
    names = [f"Floor/caustics_{n:04d}.exr" for n in (1, 2, 3)]
    assert files_in(out) == [*names, "bake.json"]
    for n, name in enumerate(names):
        np.testing.assert_allclose(read_exr(out / name).astype(float), 1.0 + 0.1 * n, rtol=HALF)
    assert pool.frame_current == 2


def test_record_holds_what_was_done(pool, out):
    run(pool, frames=(2,))
    known = record(out)
    assert known["version"] == 1
    assert known["blender"] == bpy.app.version_string
    assert (known["water"], known["receivers"]) == (["Water"], ["Floor"])
    assert known["settings"]["resolution"] == 16
    entry = known["frames"]["2"]
    assert (entry["method"], entry["reason"]) == ("by_height", "a test asked for it")
    assert entry["flux_in"] == [4, 4, 4]
    assert entry["flux_received"] == {"Floor": [3, 3, 3]}
    assert entry["flux_lost"] == {"rim": [1, 1, 1]}
    assert entry["eta"] == 1.333
    assert (entry["sigma_a"], entry["lights"][0]["type"]) == ([0, 0, 0], "sun")
    assert entry["lights"][0]["direction"] == pytest.approx([0, 0, -1])
    assert entry["files"] == {"Floor": "Floor/caustics_0002.exr"}
    assert entry["warnings"] == []
    assert set(entry["seconds"]) == {"extract", "texels", "solve", "solve.think", "write"}
    assert entry["seconds"]["solve.think"] == 0.25


def test_later_bake_adds_and_replaces_frames(pool, out):
    run(pool, frames=(1, 10))
    first = record(out)["frames"]
    run(pool, frames=(2, 10), settings=replace(request_from_scene(pool).settings, resolution=32))
    frames = record(out)["frames"]
    assert list(frames) == ["1", "2", "10"]
    assert frames["1"] == first["1"]
    assert frames["10"]["settings"]["resolution"] == 32
    assert read_exr(out / "Floor/caustics_0010.exr").shape == (32, 32, 3)
    assert read_exr(out / "Floor/caustics_0001.exr").shape == (16, 16, 3)


def test_texels_are_made_once_while_the_receiver_rests(pool, monkeypatch):
    from dapple.kernels.maps import texels

    made = []
    real = texels.rasterise
    monkeypatch.setattr(
        texels, "rasterise", lambda receiver, *size: made.append(receiver.name) or real(receiver, *size)
    )
    add_grid("Lift", -1.0, pool.dapple.receivers)
    lift = bpy.data.objects["Lift"]
    for frame, z in ((2, -1.0), (3, -0.5)):
        lift.location.z = z
        lift.keyframe_insert("location", frame=frame)
    run(pool)
    assert sorted(made) == ["Floor", "Lift", "Lift"]


def test_failing_frame_keeps_those_before(pool, out, monkeypatch):
    calls = []

    def solve(*arguments):
        calls.append(1)
        if len(calls) == 3:
            raise DappleError("the light went out.")
        return solve_by_height(*arguments)

    use_solver(monkeypatch, solve)
    pool.frame_set(2)
    with pytest.raises(DappleError, match=r"Frame 3: the light went out\."):
        run(pool)
    assert files_in(out) == ["Floor/caustics_0001.exr", "Floor/caustics_0002.exr", "bake.json"]
    assert list(record(out)["frames"]) == ["1", "2"]
    assert pool.frame_current == 2


def test_closed_iterator_puts_the_frame_back(pool, out):
    pool.frame_set(3, subframe=0.5)
    steps = bake(bpy.context, request_from_scene(pool))
    next(steps)
    assert pool.frame_current == 1
    steps.close()
    assert (pool.frame_current, pool.frame_subframe) == (3, 0.5)
    assert list(record(out)["frames"]) == ["1"]


def test_render_settings_and_data_stay(pool):
    render = pool.render.image_settings
    before = (render.file_format, render.color_depth, pool.render.filepath, len(bpy.data.images), len(bpy.data.meshes))
    run(pool)
    after = (render.file_format, render.color_depth, pool.render.filepath, len(bpy.data.images), len(bpy.data.meshes))
    assert after == before


def test_awkward_names_get_folders_of_their_own(pool, out):
    bpy.data.objects["Floor"].name = "a/b"
    add_grid("a:b", -1.0, pool.dapple.receivers)
    run(pool, frames=(1,))
    files = record(out)["frames"]["1"]["files"]
    assert set(files) == {"a/b", "a:b"}
    assert len(set(files.values())) == 2
    assert files_in(out) == sorted([*files.values(), "bake.json"])


def test_warnings_reach_the_record(pool, out):
    panel = bpy.data.objects.new("Panel", bpy.data.lights.new("Panel", "AREA"))
    pool.collection.objects.link(panel)
    panel.scale.x = 0.0
    run(pool, frames=(1,))
    (warning,) = record(out)["frames"]["1"]["warnings"]
    assert "'Panel' has no area" in warning


@pytest.mark.bpy_module
def test_buttons_load_without_embreex(root):
    code = "import sys, dapple.operators.buttons.ops_bake; sys.exit('embreex' in sys.modules)"
    hook = "import runpy, sys; runpy.run_path(sys.argv[1] + '/tests/conftest.py'); "
    assert subprocess.run([sys.executable, "-c", hook + code, str(root)], check=False).returncode == 0


def test_rough_pictures_come_first_and_change_nothing(empty_scene, out, tmp_path):
    build_pool(empty_scene, out)
    run(empty_scene, frames=(1,))
    alone = read_exr(out / "Floor/caustics_0001.exr")
    request = replace(request_from_scene(empty_scene), frames=(1,))
    (tmp_path / "rough").mkdir()
    steps = bake(bpy.context, request, tmp_path / "rough")
    (out / "Floor/caustics_0001.exr").unlink()
    assert next(steps).folder == tmp_path / "rough"
    assert files_in(tmp_path / "rough") == ["Floor/caustics_0001.exr"]
    assert files_in(out) == ["bake.json"], "the maps are for whole frames only"
    *_, last = steps
    assert (last.frame, last.done) == (1, 1)
    np.testing.assert_array_equal(read_exr(out / "Floor/caustics_0001.exr"), alone)


def test_maps_are_half_floats_unless_full_ones_are_asked_for(pool, out):
    run(pool, frames=(2,))
    assert read_exr(out / "Floor/caustics_0002.exr").dtype == np.float16
    assert record(out)["depth"] == "half"
    pool.dapple.depth = "FULL"
    run(pool, frames=(2,))
    image = read_exr(out / "Floor/caustics_0002.exr")
    assert image.dtype == np.float32
    np.testing.assert_allclose(image, 1.1, rtol=1e-6)
    assert record(out)["depth"] == "full"
