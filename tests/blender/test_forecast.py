"""What the panel says a bake will take: from counts, before it starts."""

import bpy
import pytest

from dapple.kernels.scene import Settings
from dapple.operators.bake import forecast as module
from dapple.operators.bake import memory
from dapple.operators.bake.forecast import forecast, size
from dapple.tests.blender.attach_scene import principled, shader
from dapple.tests.blender.small_pool import add_grid, build_pool


@pytest.fixture
def pool(empty_scene, tmp_path):
    build_pool(empty_scene, tmp_path / "out")
    bpy.context.view_layer.update()
    module._cast.clear()
    return empty_scene


def test_it_is_that_of_the_frames_counts(pool):
    add_grid("Wall", -1.0, pool.dapple.receivers)
    bpy.context.view_layer.update()
    pool.dapple.resolution, pool.dapple.workers = 1024, 2
    workers, each = forecast(pool, bpy.context.view_layer)
    assert workers == 2
    settings = Settings(resolution=1024, tolerance=pool.dapple.tolerance)
    assert each == memory.memory_per_worker(32, 0, 64, (1024, 1024), settings)


def test_glass_counts(pool, monkeypatch):
    before = forecast(pool, bpy.context.view_layer)[1]
    ball(pool)
    assert forecast(pool, bpy.context.view_layer)[1] == before, "looked at a moment ago"
    monkeypatch.setattr(module, "_SECONDS", 0.0)
    bpy.context.view_layer.update()
    settings = Settings(resolution=16, tolerance=pool.dapple.tolerance)
    assert forecast(pool, bpy.context.view_layer)[1] == memory.memory_per_worker(32, 960, 32, (16,), settings)


def ball(scene):
    """A ball of glass, of 960 triangles, beside the pool."""
    bpy.ops.mesh.primitive_uv_sphere_add(location=(5, 0, 0))
    material = principled("Glass")
    shader(material).inputs["Transmission Weight"].default_value = 1.0
    shader(material).inputs["Roughness"].default_value = 0.0
    bpy.context.object.data.materials.append(material)


def test_each_map_has_its_own_size_where_density_is_set(pool):
    step = add_grid("Step", 0.3, pool.dapple.receivers)
    step.scale = 0.25, 0.25, 1.0
    bpy.context.view_layer.update()
    pool.dapple.texels_per_metre = 60.0
    settings = Settings(resolution=16, tolerance=pool.dapple.tolerance)
    expected = memory.memory_per_worker(32, 0, 64, (128, 32), settings)
    assert forecast(pool, bpy.context.view_layer)[1] == expected


def test_modifiers_count(pool):
    pool.dapple.surface = "mesh"
    before = forecast(pool, bpy.context.view_layer)[1]
    pool.dapple.water.modifiers.new("Subdivision", "SUBSURF").levels = 6
    bpy.context.view_layer.update()
    assert forecast(pool, bpy.context.view_layer)[1] - before == pytest.approx(memory._TRIANGLE * 32 * (4**6 - 1))


def test_a_scene_without_water_has_a_forecast_too(pool):
    pool.dapple.water = pool.dapple.receivers = None
    assert forecast(pool, bpy.context.view_layer)[0] >= 1


def test_workers_are_bounded_by_frames_cores_and_memory(monkeypatch):
    monkeypatch.setattr(memory, "cores", lambda: 8)
    monkeypatch.setattr(memory, "free_memory", lambda: 10e9)
    assert memory.count_workers(0, 100, 1e9) == 8
    assert memory.count_workers(0, 100, 2e9) == 4, "four fifths of what is free"
    assert memory.count_workers(0, 100, 50e9) == 1
    assert memory.count_workers(0, 3, 1e9) == 3
    assert memory.count_workers(20, 100, 2e9) == 20, "who asks for more gets it"
    assert memory.count_workers(20, 3, 2e9) == 3


def test_this_machine_has_cores_and_memory():
    assert memory.cores() >= 1
    assert 1e6 < memory.free_memory() < 1e15


@pytest.mark.parametrize(("count", "text"), [(8.04e7, "80 MB"), (9.9e8, "990 MB"), (1.26e9, "1.3 GB")])
def test_sizes_read_as_people_say_them(count, text):
    assert size(count) == text
