"""What the panel says a bake will take: from counts, before it starts."""

import bpy
import pytest

from dapple.kernels.scene import Settings
from dapple.operators.bake import memory
from dapple.operators.bake.forecast import forecast, size
from dapple.tests.blender.small_pool import add_grid, build_pool


@pytest.fixture
def pool(empty_scene, tmp_path):
    build_pool(empty_scene, tmp_path / "out")
    bpy.context.view_layer.update()
    return empty_scene


def test_it_is_that_of_the_frames_counts(pool):
    add_grid("Wall", -1.0, pool.dapple.receivers)
    bpy.context.view_layer.update()
    pool.dapple.resolution, pool.dapple.workers = 1024, 2
    workers, each = forecast(pool, bpy.context.view_layer)
    assert workers == 2
    assert each == memory.memory_per_worker(
        32, (1024, 1024), Settings(resolution=1024, tolerance=pool.dapple.tolerance)
    )


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
