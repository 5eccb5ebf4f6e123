"""The button that shows what became of each texel."""

from __future__ import annotations

import bpy

from ..bake.bake import request_from_scene
from ..errors import DappleError
from ..maps.overlay import show
from .explained import Explained


class DAPPLE_OT_show_status(Explained, bpy.types.Operator):
    """Solve the current frame again and paint what became of each texel: grey is fine, colours say why a texel has no \
light or not all of it. One image per receiver, shown in the Image Editors that are open"""

    bl_idname = "dapple.show_status"
    bl_label = "Show Texel Status"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        from ..bake.solve_now import Now

        try:
            # Of the folder nothing is asked: a file that is not saved yet has none.
            request = request_from_scene(context.scene, frames=(context.scene.frame_current,), out="unused")
            images = show(*Now(request).solve(context))
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        editors = [space for space in _image_editors(context.window_manager) if not space.use_image_pin]
        for space, image in zip(editors, images, strict=False):
            space.image = image
        where = "shown in the Image Editor" if editors else "open one in an Image Editor"
        self.report({"INFO"}, f"{', '.join(image.name for image in images)}: {where}")
        return {"FINISHED"}


def _image_editors(window_manager):
    """The image editors of all windows."""
    areas = (area for window in window_manager.windows for area in window.screen.areas)
    return [area.spaces.active for area in areas if area.type == "IMAGE_EDITOR"]
