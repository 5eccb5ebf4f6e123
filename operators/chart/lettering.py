"""Text for a Canvas, by the letters that Blender has built in."""

from __future__ import annotations

import contextlib

import bpy
import numpy as np

_NAME = "Dapple lettering"


@contextlib.contextmanager
def lettering():
    """Give a Lettering, and leave nothing of it in the file."""
    fonts = set(bpy.data.fonts)
    curve = bpy.data.curves.new(_NAME, "FONT")
    holder = bpy.data.objects.new(_NAME, curve)
    try:
        yield Lettering(holder)
    finally:
        bpy.data.objects.remove(holder)
        bpy.data.curves.remove(curve)
        for font in set(bpy.data.fonts) - fonts:
            bpy.data.fonts.remove(font)


class Lettering:
    """Triangles of texts; a size is the height of a line [units of the canvas]."""

    def __init__(self, holder):
        self._holder, self._known = holder, {}

    def width(self, text, size):
        """How wide a text is."""
        triangles = self._triangles(text)
        return float(triangles[..., 0].max() * size) if len(triangles) else 0.0

    def draw(self, canvas, x, y, text, size, colour, align=0.0, upright=False):
        """Draw a text whose base line begins at (x, y), is centred there (align 0.5), or ends there (1); upright: it
        runs upward."""
        triangles = self._triangles(text) * size - [align * self.width(text, size), 0.0]
        if upright:
            triangles = np.stack([-triangles[..., 1], triangles[..., 0]], -1)
        canvas.fill(triangles + np.array([x, y]), colour)

    def _triangles(self, text):
        """Triangles (T,3,2) of a text of size 1."""
        if text not in self._known:
            self._known[text] = self._shape(text)
        return self._known[text]

    def _shape(self, text):
        self._holder.data.body = text
        mesh = self._holder.to_mesh()
        try:
            mesh.calc_loop_triangles()
            corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
            mesh.loop_triangles.foreach_get("vertices", corners)
            places = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", places)
        finally:
            self._holder.to_mesh_clear()
        return places.reshape(-1, 3)[corners, :2].reshape(-1, 3, 2).astype(float)
