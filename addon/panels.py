"""The tab "Dapple" in the 3D view's sidebar, laid out as Blender's own Bake panel: button on top, then the rest."""

from __future__ import annotations

import bpy

from ..operators.bake.forecast import forecast, size
from ..operators.buttons.choose import flagged_receivers
from ..operators.read.density import side_in_metres, size_for
from ..operators.read.receivers import can_receive
from ..operators.show import live


class Sidebar:
    """What all panels have in common; those with a parent are its sub-panels."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Dapple"

    def column(self):
        """The panel's layout, names on the left and values on the right as in Blender's properties."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout


class DAPPLE_PT_bake(Sidebar, bpy.types.Panel):
    """Bake, how well, and show what was baked."""

    bl_label = "Bake"

    def draw(self, context):
        settings, layout = context.scene.dapple, self.layout
        if context.window_manager.dapple.running:
            _draw_progress(layout, context)
        buttons = layout.column(align=True)
        buttons.operator("dapple.bake_frame", icon="RENDER_STILL")
        buttons.operator("dapple.bake_animation", icon="RENDER_ANIMATION")
        layout.row(align=True).prop(settings, "quality", expand=True)
        layout.operator("dapple.live_preview", icon="PLAY", depress=live.is_on())
        shown = layout.column(align=True)
        shown.operator("dapple.attach", icon="LINKED")
        shown.operator("dapple.look_through", icon="HIDE_OFF")
        shown.operator("dapple.detach", icon="UNLINKED")
        wrapped(layout, context, live.trouble(), icon="ERROR")


class DAPPLE_PT_scene(Sidebar, bpy.types.Panel):
    """Which water lights what."""

    bl_label = "Water and Receivers"
    bl_parent_id = "DAPPLE_PT_bake"

    def draw(self, context):
        settings, layout = context.scene.dapple, self.column()
        layout.prop(settings, "water")
        layout.prop(settings, "receivers")
        if settings.receivers is None:
            flagged = flagged_receivers(context.scene)
            if flagged:
                wrapped(layout, context, f"Receive Shadow Caustics marks {len(flagged)} receiver(s)", icon="INFO")
            layout.operator("dapple.choose", icon="RESTRICT_SELECT_OFF")
        layout.operator("dapple.lightmap_uvs", icon="UV")
        _draw_map(layout, settings, context.object)


class DAPPLE_PT_casters(Sidebar, bpy.types.Panel):
    """What else throws caustics: objects of glass and polished metal, found by their materials."""

    bl_label = "Glass and Metal"
    bl_parent_id = "DAPPLE_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        settings, active, layout = context.scene.dapple, context.object, self.column()
        if active and active.type == "MESH":
            layout.prop(active.dapple, "caustics", text=active.name, translate=False)
            for name in ("ior", "abbe"):
                layout.prop(active.dapple, name)
        layout.prop(settings, "bounces")
        layout.prop(settings, "volume")
        sides = layout.row(align=True)
        sides.enabled = settings.volume is not None
        sides.prop(settings, "culling")


class DAPPLE_PT_influence(Sidebar, bpy.types.Panel):
    """What of the light is in the maps."""

    bl_label = "Influence"
    bl_parent_id = "DAPPLE_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.column()
        for name in ("dispersion", "match_cycles", "reuse"):
            layout.prop(context.scene.dapple, name)


class DAPPLE_PT_quality(Sidebar, bpy.types.Panel):
    """How the light is found."""

    bl_label = "Quality"
    bl_parent_id = "DAPPLE_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.column()
        for name in ("tolerance", "method", "surface"):
            layout.prop(context.scene.dapple, name)
        layout.operator("dapple.chart", icon="IPO_EXPO")


class DAPPLE_PT_output(Sidebar, bpy.types.Panel):
    """Which frames, and where and how the maps are kept."""

    bl_label = "Output"
    bl_parent_id = "DAPPLE_PT_bake"

    def draw(self, context):
        settings, layout = context.scene.dapple, self.column()
        sizes = layout.column()
        sizes.enabled = not settings.texels_per_metre
        sizes.prop(settings, "resolution")
        layout.prop(settings, "texels_per_metre")
        layout.prop(settings, "use_scene_range")
        frames = layout.column(align=True)
        frames.enabled = not settings.use_scene_range
        owner = context.scene if settings.use_scene_range else settings  # greyed, they show what will be baked
        frames.prop(owner, "frame_start", text="Start")
        frames.prop(owner, "frame_end", text="End")
        layout.prop(settings, "output")
        layout.prop(settings, "depth")
        layout.prop(settings, "tile")
        layout.prop(settings, "workers")
        workers, each = forecast(context.scene, context.view_layer)
        status = f"{workers} at once, about {size(each)} each"
        layout.label(text=status, icon="MEMORY", translate=False)


class DAPPLE_PT_margin(Sidebar, bpy.types.Panel):
    """How far the light is spread past the UV islands."""

    bl_label = "Margin"
    bl_parent_id = "DAPPLE_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.column().prop(context.scene.dapple, "padding")


def wrapped(layout, context, text, icon="NONE"):
    """Show a text in as many lines as the sidebar's width takes; nothing where there is none."""
    import textwrap

    width = max(int(context.region.width / (7 * context.preferences.system.ui_scale)), 20) if context.region else 40
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1" if icon != "NONE" else "NONE", translate=False)


def _receivers(settings):
    """Names of what is picked as receivers, or of what Cycles' flag marks."""
    return settings.receivers.all_objects if settings.receivers else flagged_receivers(settings.id_data)


def _draw_map(layout, settings, active):
    """Where the light of the active object is kept, if it is a receiver."""
    if active and active.name in _receivers(settings) and can_receive(active):
        column = layout.column(heading=active.name)
        column.prop(active.dapple, "shared_map")
        if active.type == "MESH":
            column.prop(active.dapple, "instances_receive")
            _draw_density(column, settings, active)


def _draw_progress(layout, context):
    """How far the running bake is, a button that stops it, and what its workers are at."""
    bake = context.window_manager.dapple
    status = f"{bake.part:.0%}"
    layout.progress(factor=bake.part, text=status, translate=False)
    layout.operator("dapple.stop", icon="CANCEL")  # above the text, whose lines come and go
    wrapped(layout, context, bake.text)


def _draw_density(column, settings, active):
    """How fine the map of the active receiver is at the resolution that is set."""
    side = side_in_metres(active)
    if side is None:
        column.label(text="No UV map yet: the bake makes one", icon="INFO")
        return
    split = column.split(factor=0.6)
    split.label(text="Texels per Metre")
    resolution, density = settings.resolution, settings.texels_per_metre
    if density:
        resolution = size_for(side, density, resolution)
    split.label(text=f"{resolution / side:.4g} ({resolution} x {resolution})", translate=False)
