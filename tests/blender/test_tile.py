"""A tileable map of Blender's own ocean, which repeats."""

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.tests.blender.attach_scene import plane
from dapple.tests.blender.exr_reader import read_exr


@pytest.fixture
def ocean(empty_scene, tmp_path):
    """One tile of 4 m of choppy ocean, a floor of the same size 2 m below, a slanting sun."""
    mesh = bpy.data.meshes.new("Ocean")
    mesh.from_pydata([(0, 0, 0)], [], [])
    water = bpy.data.objects.new("Ocean", mesh)
    empty_scene.collection.objects.link(water)
    waves = water.modifiers.new("Ocean", "OCEAN")
    waves.geometry_mode, waves.size, waves.spatial_size = "GENERATE", 1.0, 4
    waves.resolution = waves.viewport_resolution = 5
    waves.wave_scale, waves.choppiness, waves.random_seed = 0.15, 0.5, 3
    floor = plane("Floor", size=4.0)
    water.location = (0, 0, 2.0)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler.x, sun.data.energy = 0.4, 1.0
    empty_scene.collection.objects.link(sun)
    receivers = bpy.data.collections.new("Receivers")
    receivers.objects.link(floor)
    settings = empty_scene.dapple
    settings.water, settings.receivers, settings.output = water, receivers, str(tmp_path)
    settings.resolution, settings.tile, settings.workers = 32, True, 1
    bpy.context.view_layer.update()
    corners = np.array([water.matrix_world @ v.co for v in evaluated_vertices(water)])
    water.location.x -= (corners[:, 0].max() + corners[:, 0].min()) / 2
    return empty_scene


def evaluated_vertices(obj):
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices


def test_ocean_tiles(ocean, tmp_path):
    """Its rows at the border differ from those across it by no more than rows inside differ from each other."""
    (progress,) = bake(bpy.context, request_from_scene(ocean, frames=(5,)))
    image = read_exr(tmp_path / "Floor" / "caustics_0005.exr").astype(float)[..., 0]
    assert image.std() > 0.1 * image.mean()
    for axis in (0, 1):
        steps = np.abs(np.diff(image, axis=axis, append=np.take(image, [0], axis))).mean(1 - axis)
        assert steps[-1] <= steps[:-1].max()
    assert "100.0%" not in progress.message and "received" in progress.message


def test_what_does_not_tile_is_said(ocean):
    bpy.data.objects["Ocean"].modifiers[0].repeat_x = 2
    with pytest.raises(DappleError, match="must be one tile of the same size"):
        list(bake(bpy.context, request_from_scene(ocean, frames=(5,))))
