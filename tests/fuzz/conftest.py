"""The fixtures of the tests that need Blender."""

from dapple.tests.blender.conftest import empty_scene

__all__ = ["empty_scene"]
