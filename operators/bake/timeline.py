"""The frames of a scene, held by names: an undo or an edit replaces what Blender's own references point to."""

from __future__ import annotations

import bpy

from ..errors import DappleError
from ..read.caches import Player


class Timeline:
    """The frames of a context's scene and view layer."""

    def __init__(self, context):
        self._scene, self._layer = context.scene.name, context.view_layer.name
        self._player, self._left = Player(self._scene), None

    def at(self, number):
        """The depsgraph of a frame, evaluated. Raises DappleError where the scene or its view layer is gone."""
        scene = bpy.data.scenes.get(self._scene)
        layer = scene and scene.view_layers.get(self._layer)
        if layer is None:
            raise DappleError(f"Scene '{self._scene}' or its view layer '{self._layer}' is gone; bake again.")
        self._left = self._left or (scene.frame_current, scene.frame_subframe)
        self._player.go(number)
        with bpy.context.temp_override(scene=scene, view_layer=layer):
            return bpy.context.evaluated_depsgraph_get()

    def rest(self):
        """Go back to the frame that was left for those that were read, so that the artist stays where they were; not
        where a simulation has to be played on from where it is."""
        scene = bpy.data.scenes.get(self._scene)
        if scene and not self._player.plays(scene):
            self.restore()

    def restore(self):
        """Put the scene's frame back as it was, if there is a scene still."""
        if self._left and self._scene in bpy.data.scenes:
            frame, subframe = self._left
            bpy.data.scenes[self._scene].frame_set(frame, subframe=subframe)
        self._left = None
