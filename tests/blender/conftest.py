"""Fixtures for tests that need Blender, here as the Python module bpy."""

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
