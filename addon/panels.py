"""The tab "Dapple" in the sidebar of the 3D view."""

from __future__ import annotations

import bpy

from ..operators.receivers import can_receive


class _Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dapple"


class DAPPLE_PT_bake(_Sidebar, bpy.types.Panel):
    """Which water lights what, in which frames, and where the maps go."""

    bl_label = "Bake"

    def draw(self, context):
        settings = context.scene.dapple
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "water")
        layout.prop(settings, "receivers")
        _draw_map(layout, settings, context.object)
        _draw_frames(layout, settings)
        layout.prop(settings, "output")
        layout.prop(settings, "depth")
        buttons = layout.column(align=True)
        buttons.operator("dapple.bake_frame", icon="RENDER_STILL")
        buttons.operator("dapple.bake_animation", icon="RENDER_ANIMATION")


class DAPPLE_PT_casters(_Sidebar, bpy.types.Panel):
    """What else throws caustics: objects of glass and polished metal, found by their materials."""

    bl_label = "Glass and Metal"
    bl_parent_id = "DAPPLE_PT_bake"

    def draw(self, context):
        settings, active = context.scene.dapple, context.object
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        if active and active.type == "MESH":
            layout.prop(active.dapple, "caustics", text=active.name)
        layout.prop(settings, "bounces")
        layout.prop(settings, "volume")
        sides = layout.row(align=True)
        sides.enabled = settings.volume is not None
        sides.prop(settings, "culling")


class DAPPLE_PT_quality(_Sidebar, bpy.types.Panel):
    """How the light is found and how finely it is kept."""

    bl_label = "Quality"
    bl_parent_id = "DAPPLE_PT_bake"

    def draw(self, context):
        settings = context.scene.dapple
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("method", "surface", "tolerance", "resolution", "padding", "dispersion", "match_cycles", "reuse"):
            layout.prop(settings, name)


class DAPPLE_PT_materials(_Sidebar, bpy.types.Panel):
    """Show the baked maps on the receivers, or stop showing them."""

    bl_label = "Materials"

    def draw(self, context):
        buttons = self.layout.column(align=True)
        buttons.operator("dapple.attach", icon="LINKED")
        buttons.operator("dapple.detach", icon="UNLINKED")


def _draw_map(layout, settings, active):
    """Where the light of the active object is kept, if it is a receiver."""
    if active and settings.receivers and active.name in settings.receivers.all_objects and can_receive(active):
        column = layout.column(heading=active.name)
        column.prop(active.dapple, "shared_map")
        if active.type == "MESH":
            column.prop(active.dapple, "instances_receive")


def _draw_frames(layout, settings):
    layout.prop(settings, "use_scene_range")
    frames = layout.column(align=True)
    frames.enabled = not settings.use_scene_range
    frames.prop(settings, "frame_start")
    frames.prop(settings, "frame_end")
