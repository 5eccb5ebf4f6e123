"""Whatever is wrong with a scene is said in a sentence that names it, and costs nothing that was baked before."""

import math
import shutil
import subprocess
from dataclasses import replace

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.operators.maps.exr_file import is_whole
from dapple.tests.blender.small_pool import add_grid, build_pool, files_in, solve_by_height, use_solver


@pytest.fixture
def pool(empty_scene, tmp_path, monkeypatch):
    build_pool(empty_scene, tmp_path / "out")
    use_solver(monkeypatch, solve_by_height)
    return empty_scene


def objects(name):
    return bpy.data.objects[name]


def run(scene, **changes):
    return list(bake(bpy.context, replace(request_from_scene(scene), **changes)))


def set_uvs(change):
    for uv in objects("Floor").data.uv_layers[0].data:
        uv.uv = change(*uv.uv)


def no_water(scene):
    scene.dapple.water = None


def no_receivers(scene):
    scene.dapple.receivers = None


def empty_collection(scene):
    scene.dapple.receivers.objects.unlink(objects("Floor"))


def empty_range(scene):
    settings = scene.dapple
    settings.use_scene_range, settings.frame_start, settings.frame_end = False, 9, 8


def water_without_faces(scene):
    objects("Water").modifiers.new("Gone", "MASK").vertex_group = objects("Water").vertex_groups.new().name


def water_not_finite(scene):
    objects("Water").data.vertices[3].co.z = math.nan
    objects("Water").data.vertices[5].co.x = math.nan


def receiver_not_finite(scene):
    objects("Floor").data.vertices[0].co.y = math.nan


def receiver_without_faces(scene):
    objects("Floor").data.clear_geometry()


def no_uvs(scene):
    mesh = objects("Floor").data
    mesh.uv_layers.remove(mesh.uv_layers[0])
    mesh.update()


def folded_uvs(scene):
    set_uvs(lambda u, v: (abs(2 * u - 1), v))


def flat_uvs(scene):
    set_uvs(lambda u, v: (u, 0.5))


def far_uvs(scene):
    set_uvs(lambda u, v: (u + 0.3, v))


def uvs_not_finite(scene):
    set_uvs(lambda u, v: (math.nan, v))


def no_sun(scene):
    bpy.data.objects.remove(objects("Sun"))


def unrendered_sun(scene):
    objects("Sun").hide_render = True


def flat_area(scene):
    objects("Sun").data.type = "AREA"
    objects("Sun").scale.y = 0.0


def sunken_bulb(scene):
    objects("Sun").data.type = "POINT"
    objects("Sun").location.z = 0.5


def sun_below(scene):
    objects("Sun").rotation_euler.x = math.radians(100)


def heavy_water(scene):
    material = bpy.data.materials.new("Lead")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["IOR"].default_value = 5.0
    objects("Water").data.materials.append(material)


def impossible_abbe(scene):
    scene.dapple.dispersion = 0.5


def relative_output(scene):
    scene.dapple.output = "maps"


BROKEN = [
    (no_water, r"Nothing bends light or mirrors it: pick the water, or give an object glass"),
    (no_receivers, r"No receivers are chosen; pick"),
    (empty_collection, r"Collection 'Receivers' holds no mesh but the water; put"),
    (empty_range, r"The frame range is empty: it starts at 9 and ends at 8; set"),
    (water_without_faces, r"Frame 1: Water 'Water' has no faces after its modifiers; check"),
    (water_not_finite, r"Frame 1: Water 'Water' has coordinates that are not numbers at 2 of its 25 vertices; check"),
    (receiver_not_finite, r"Receiver 'Floor' has coordinates that are not numbers at 1 of its 25 vertices; check"),
    (receiver_without_faces, r"Receiver 'Floor' has no faces after its modifiers; check"),
    (no_uvs, r"Receiver 'Floor' has no UV map; unwrap it"),
    (folded_uvs, r"Receiver 'Floor' cannot take a lightmap: .*overlap.*; unwrap it"),
    (flat_uvs, r"Receiver 'Floor' cannot take a lightmap: .*no area; unwrap it"),
    (far_uvs, r"Receiver 'Floor' cannot take a lightmap: .*unit square.*; scale it"),
    (uvs_not_finite, r"Receiver 'Floor' cannot take a lightmap: .*not numbers; unwrap it"),
    (no_sun, r"no lamp that renders and shines on what bends light\. Add one"),
    (unrendered_sun, r"no lamp that renders and shines on what bends light\. Add one"),
    (flat_area, r"no lamp that renders and shines on what bends light.*'Sun' has no area .*: set its size"),
    (sunken_bulb, r"no lamp that renders and shines.*'Sun' is under the water .*: move it above"),
    (sun_below, r"Sun 'Sun' shines upward and was left out: rotate it"),
    (heavy_water, r"Water 'Water' has IOR 5 in its material 'Lead'; set it between"),
    (impossible_abbe, r"An Abbe number of 0.5 is impossible; set 0 for no dispersion"),
    (relative_output, r"output folder 'maps' is no full path; start it with //"),
]


@pytest.mark.parametrize(("spoil", "sentence"), BROKEN, ids=[spoil.__name__ for spoil, _ in BROKEN])
def test_scene_that_cannot_be_baked(pool, tmp_path, spoil, sentence):
    run(pool, frames=(7,))
    before = {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)}
    assert len(before) == 2
    spoil(pool)
    with pytest.raises(DappleError, match=sentence):
        run(pool)
    assert {name: (tmp_path / name).read_bytes() for name in files_in(tmp_path)} == before


CHANGES = [
    ({"water": ()}, r"Nothing bends light or mirrors it: pick the water"),
    ({"water": ("Sea",)}, r"no object 'Sea' in the file; check the name"),
    ({"water": ("Sun",)}, r"'Sun' is a light, not a mesh; convert it"),
    ({"receivers": ()}, r"no receivers; pick"),
    ({"receivers": ("Ground",)}, r"no object 'Ground' in the file; check the name"),
    ({"receivers": ("Floor", "Water")}, r"'Water' is both water and receiver; take it out"),
    ({"frames": ()}, r"no frames to bake from 0 on; set"),
    ({"frames": (-1, 0)}, r"no frames to bake from 0 on; set"),
]


@pytest.mark.parametrize(("changes", "sentence"), CHANGES)
def test_request_that_cannot_be_met(pool, tmp_path, changes, sentence):
    with pytest.raises(DappleError, match=sentence):
        run(pool, **changes)
    assert files_in(tmp_path) == []


@pytest.mark.parametrize(
    ("setting", "value", "sentence"),
    [
        ("resolution", 8, r"resolution of 8 is out of range; set 16 to 16384"),
        ("resolution", 20000, r"resolution of 20000 is out of range"),
        ("tolerance", 0.0, r"tolerance of 0 cannot be met; set one above 0"),
        ("tolerance", math.nan, r"tolerance of nan cannot be met"),
    ],
)
def test_settings_out_of_range(pool, setting, value, sentence):
    settings = replace(request_from_scene(pool).settings, **{setting: value})
    with pytest.raises(DappleError, match=sentence):
        run(pool, settings=settings)


def test_relative_output_of_an_unsaved_file(pool):
    pool.dapple.property_unset("output")
    with pytest.raises(DappleError, match=r"'//caustics' is relative to a file not saved yet; save it"):
        request_from_scene(pool)


def test_receivers_that_differ_in_case_only(pool):
    add_grid("floor", -1.0, pool.dapple.receivers)
    with pytest.raises(DappleError, match=r"'Floor' and 'floor' would share a folder on some systems; rename one"):
        run(pool)


def test_output_below_a_file(pool, tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(DappleError, match=r"Could not write .*maps: a part of this path is a file.*choose another"):
        run(pool, out=tmp_path / "file" / "maps")
    assert files_in(tmp_path) == ["file"]


@pytest.mark.parametrize("text", ["{", "[]", '{"version": 99, "frames": {}}', '{"version": 1, "frames": {"x": {}}}'])
def test_record_of_something_else_is_not_overwritten(pool, tmp_path, text):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "bake.json").write_text(text)
    with pytest.raises(DappleError, match=r"bake\.json .*; move it away or choose another folder"):
        run(pool)
    assert files_in(tmp_path) == ["out/bake.json"]
    assert (tmp_path / "out" / "bake.json").read_text() == text


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 64 KiB, where this user may mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = shutil.which("mount")
    command = [mount or "mount", "-t", "tmpfs", "-o", "size=64k", "none", str(disk)]
    if not mount or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("only root on Linux may mount a small disk")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def test_disk_that_fills_up_keeps_whole_frames(pool, small_disk, monkeypatch):
    noise = np.random.default_rng(1).random((32, 32, 3))  # which nothing can compress

    def solve(*given):
        return replace(solve_by_height(*given), images=(noise,))

    use_solver(monkeypatch, solve)
    settings = replace(request_from_scene(pool).settings, resolution=32)
    with pytest.raises(DappleError, match=r"Could not write .*no space left on the disk; free some space"):
        run(pool, out=small_disk, settings=settings, frames=tuple(range(1, 12)))
    files = files_in(small_disk)
    maps = [small_disk / name for name in files if name.endswith(".exr")]
    assert 1 <= len(maps) < 11
    assert all(is_whole(path) for path in maps)
    assert set(files) == {"bake.json", *(path.relative_to(small_disk).as_posix() for path in maps)}
