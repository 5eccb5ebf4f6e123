"""Blender's operators: what buttons and the search call. They hold no work of their own."""
