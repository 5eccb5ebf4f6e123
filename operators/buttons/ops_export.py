"""The button that makes loops, PNG, atlases and cookies of the baked maps."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty

from ..bake.bake import output_folder, request_from_scene
from ..errors import DappleError
from ..maps.export import Export, export
from .explained import Explained, receivers_lacking

FORMS = (
    ("sequence", "Image Sequence", "One file for each frame"),
    ("atlas", "Flipbook Atlas", "All frames in one image, row by row from the top left, for game engines"),
    ("cookie", "Light Cookie", "One file for each frame, the light over its mean: the pattern alone, for a light"),
)


class DAPPLE_OT_export(Explained, bpy.types.Operator):
    """Make loops, PNG, flipbook atlases and light cookies of the baked maps. They are written to the folder export \
beside the maps, with a JSON file that tells what the numbers are"""

    bl_idname = "dapple.export"
    bl_label = "Export Maps"
    bl_options = {"REGISTER"}

    form: EnumProperty(name="Form", description="What to make of the maps", items=FORMS, default="atlas")
    png: BoolProperty(
        name="16-bit PNG",
        description="In place of OpenEXR. The JSON file tells what value white stands for",
        default=False,
    )
    use_loop: BoolProperty(
        name="Loop",
        description="Leave no seam in time: keep one period of the motion, if there is one, or blend the end into the "
        "start",
        default=False,
    )
    blend: IntProperty(
        name="Blend",
        description="Frames at the end that are blended into the start. 0: look for a period, else a quarter of all",
        default=0,
        min=0,
    )
    size: IntProperty(
        name="Size",
        description="Texels along each side of a frame, a divisor of what was baked; each is the mean of those that it "
        "replaces. 0: as baked",
        default=0,
        min=0,
        max=16384,
        subtype="PIXEL",
    )

    @classmethod
    def lacks(cls, context):
        return receivers_lacking(context.scene) or _not_baked(context.scene)

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("form", "png", "size", "use_loop"):
            layout.prop(self, name)
        row = layout.row()
        row.enabled = self.use_loop
        row.prop(self, "blend")

    def execute(self, context):
        wish = Export(self.form, self.png, self.blend if self.use_loop else None, self.size)
        try:
            # What is on disk is taken, whatever the range says now.
            request = request_from_scene(context.scene, frames=(context.scene.frame_current,))
            for sentence in export(context, request, wish):
                self.report({"INFO"}, sentence)
        except DappleError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def _not_baked(scene):
    """Why there is nothing to export, as a sentence for a tooltip; empty if there is."""
    try:
        baked = (Path(output_folder(scene.dapple.output)) / "bake.json").exists()
    except DappleError:
        baked = False
    return "" if baked else "Nothing is baked yet in the output folder"
