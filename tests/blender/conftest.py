"""Fixtures for tests that need Blender, here as the Python module bpy."""

import os
import sys

import numpy as np
import pytest


def pytest_sessionfinish(session, exitstatus):
    session.config.exit_code = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Leave at once under Blender 4.x as a module: it frees the functions that properties call when Python is gone,
    and crashes, whatever an add-on unregisters. All tests are over by then, and their summary is printed."""
    bpy = sys.modules.get("bpy")
    if bpy and bpy.app.version < (5, 0):
        sys.stdout.flush()
        os._exit(config.exit_code)


@pytest.fixture(autouse=True)
def _module(request):
    """Skips tests that start another Python with bpy in it, where bpy is no module but Blender itself."""
    if request.node.get_closest_marker("bpy_module"):
        bpy = pytest.importorskip("bpy")
        if bpy.app.binary_path:
            pytest.skip("inside Blender itself no other Python has bpy")


@pytest.fixture
def empty_scene():
    """An empty file with the add-on registered; gives its scene, and unregisters afterwards."""
    import bpy

    import dapple

    bpy.ops.wm.read_factory_settings(use_empty=True)
    dapple.register()
    yield bpy.context.scene
    dapple.unregister()


@pytest.fixture
def out(empty_scene, tmp_path):
    """A folder that has maps of "Floor" and "Wall" for frames 3 to 5: the irradiance is the frame's number."""
    from dapple.operators.maps.write import map_path, write_exr

    for name in ("Floor", "Wall"):
        for frame in (3, 4, 5):
            write_exr(map_path(tmp_path, name, frame), np.full((4, 4, 3), float(frame)))
    return tmp_path


@pytest.fixture
def solved(monkeypatch):
    """The water's heights that were solved, rounded."""
    from dapple.tests.blender.small_pool import solve_by_height, use_solver

    heights = []

    def solve(scene, *rest):
        heights.append(round(float(scene.water.positions[:, 2].mean()), 3))
        return solve_by_height(scene, *rest)

    use_solver(monkeypatch, solve)
    return heights


@pytest.fixture
def pool(empty_scene, tmp_path, solved):
    """The small pool, solved by the height of its water: 1, 1.1, 1.2 m and so on."""
    from dapple.tests.blender.small_pool import build_pool

    build_pool(empty_scene, tmp_path / "out")
    return empty_scene
