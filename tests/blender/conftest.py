"""Fixtures for tests that need Blender, here as the Python module bpy."""

import numpy as np
import pytest


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
    from dapple.operators.write import map_path, write_exr

    for name in ("Floor", "Wall"):
        for frame in (3, 4, 5):
            write_exr(map_path(tmp_path, name, frame), np.full((4, 4, 3), float(frame)))
    return tmp_path
