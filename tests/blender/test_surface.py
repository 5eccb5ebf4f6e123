"""From Blender's shading to the surface that the light meets: smooth water is smoothed, hand-set normals stay."""

import json

import bpy
import numpy as np
import pytest

from dapple.operators import cli
from dapple.operators.bake.bake import bake, request_from_scene
from dapple.tests.blender.small_pool import add_grid, build_pool


@pytest.fixture
def waves(empty_scene, tmp_path):
    """The small pool with waves of 32 x 32 quads on its water."""
    build_pool(empty_scene, tmp_path / "out")
    old = empty_scene.dapple.water
    old.name = "Old"
    water = add_grid("Water", 1.0, n=32)
    for vertex in water.data.vertices:
        vertex.co.z = 0.03 * np.sin(5 * vertex.co.x) * np.cos(4 * vertex.co.y)
    bpy.data.objects.remove(old)
    empty_scene.dapple.water = water
    # Texels so fine and a tolerance so low that the mesh is not enough.
    empty_scene.frame_end, empty_scene.dapple.resolution, empty_scene.dapple.tolerance = 1, 256, 1e-4
    return empty_scene


def entry(tmp_path):
    return json.loads((tmp_path / "out" / "bake.json").read_text())["frames"]["1"]


def baked(scene, tmp_path):
    list(bake(bpy.context, request_from_scene(scene)))
    return entry(tmp_path)


def test_smooth_water_is_reconstructed(waves, tmp_path):
    said = baked(waves, tmp_path)
    assert said["surface"].startswith("B-splines") and said["seconds"]["solve.surface"] > 0
    assert said["settings"]["surface"] == "auto"


def test_the_panels_setting_and_the_commands_word_keep_the_mesh(waves, tmp_path):
    waves.dapple.surface = "mesh"
    assert "asked for" in baked(waves, tmp_path)["surface"]
    assert cli.main(["bake", "--surface", "auto"]) == 0
    assert entry(tmp_path)["surface"].startswith("B-splines")
    waves.dapple.surface = "auto"
    assert cli.main(["bake", "--surface", "mesh"]) == 0
    assert "asked for" in entry(tmp_path)["surface"]


def shade_flat(mesh):
    mesh.polygons.foreach_set("use_smooth", [False] * len(mesh.polygons))
    mesh.update()


def sharpen_an_edge(mesh):
    mesh.attributes.new("sharp_edge", "BOOLEAN", "EDGE").data[200].value = True


def set_corners(mesh):
    mesh.normals_split_custom_set([(0.1, 0.0, 1.0)] * len(mesh.loops))


def set_points(mesh):
    if bpy.app.version < (4, 5):
        pytest.skip("this Blender knows custom normals of corners only")
    for normal in mesh.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT").data:
        normal.vector = (0.0995, 0.0, 0.995)


@pytest.mark.parametrize("change", [shade_flat, sharpen_an_edge, set_corners, set_points])
def test_the_artists_normals_stay(waves, tmp_path, change):
    change(waves.dapple.water.data)
    assert "flat or set by hand" in baked(waves, tmp_path)["surface"]
