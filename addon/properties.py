"""The settings that a scene keeps: `scene.dapple`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..operators.buttons.presets import CUSTOM, PRESETS, preset_of
from ..operators.read.find import can_be_water
from .choices import CAUSTICS, CULLING, DEPTHS, METHODS, QUALITIES, SURFACES

# Blender 4.5 and later want to be told that a path may start with //; earlier ones do not know the word.
BLEND_RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else set()


def _is_water(_settings, candidate) -> bool:
    return can_be_water(candidate)


def _is_box(_settings, candidate) -> bool:
    return candidate.type == "EMPTY" and candidate.empty_display_type == "CUBE"


def _quality(settings) -> int:
    names = [name for name, _, _ in QUALITIES]
    return names.index(preset_of(settings.tolerance))


def _set_quality(settings, index) -> None:
    name = QUALITIES[index][0]
    if name != CUSTOM:
        settings.tolerance = PRESETS[name]


class DappleObject(bpy.types.PropertyGroup):
    """What an object does to light, and where its own is kept."""

    caustics: EnumProperty(
        name="Caustics",
        description="Whether the active object bends or mirrors the light that is baked. Its materials say how",
        items=CAUSTICS,
        default="AUTO",
    )
    ior: FloatProperty(
        name="IOR",
        description="Index of refraction of the active object's glass, that of the matter itself: 1.5 is glass, 1 a "
        "bubble of air under water. 0 takes that of its material",
        default=0.0,
        min=0.0,
        max=4.0,
        precision=3,
    )
    abbe: FloatProperty(
        name="Abbe Number",
        description="How much less the active object's glass parts colours: 64 is crown glass, 36 flint, 55 diamond. "
        "0 takes that of the bake",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        precision=1,
    )
    shared_map: StringProperty(
        name="Map",
        description="Receivers with the same name here share one lightmap; it may be the name of one of them. Their "
        "UVs must not overlap. Empty: a map of its own",
    )
    instances_receive: BoolProperty(
        name="Instances Receive",
        description="What the active receiver shows as instances takes light too, each instance in a map of its own",
        default=False,
    )


class DappleProgress(bpy.types.PropertyGroup):
    """The bake that is running in the window: how far it is, and whether it is to stop. Not saved."""

    running: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    stop: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    part: FloatProperty(min=0.0, max=1.0, options={"HIDDEN", "SKIP_SAVE"})
    text: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def begin(self):
        self.running, self.stop, self.part, self.text = True, False, 0.0, "baking"

    def tell(self, part, text) -> bool:
        """Show how far it is, and what is under way; returns whether that is news."""
        if (news := (text != self.text)) or part != self.part:
            self.part, self.text = part, text
            self._redraw()
        return news

    def end(self):
        self.running = self.stop = False
        self._redraw()

    def _redraw(self):
        for window in self.id_data.windows:
            areas = [area for area in window.screen.areas if area.type == "VIEW_3D"]
            for region in (region for area in areas for region in area.regions if region.type == "UI"):
                region.tag_redraw()  # the sidebar only: the view itself may take long


class DappleSettings(bpy.types.PropertyGroup):
    """What to bake, how well, and where to."""

    water: PointerProperty(
        name="Water",
        description="What bends the light: an animated mesh, or an Empty that shows one; while neither it nor "
        "receivers are set, the first bake takes them from the selection. Its material gives the index of refraction, "
        "its volume what is absorbed. Objects of glass and polished metal cast caustics without being chosen",
        type=bpy.types.Object,
        poll=_is_water,
    )
    receivers: PointerProperty(
        name="Receivers",
        description="Collection of the meshes that the light falls on. Each gets a lightmap, laid out by its UV map. "
        "Empty: the meshes whose Receive Shadow Caustics is on, in their Object tab under Shading",
        type=bpy.types.Collection,
    )
    method: EnumProperty(name="Method", description="How the light is found", items=METHODS, default="auto")
    surface: EnumProperty(name="Surface", description="Which water bends the light", items=SURFACES, default="auto")
    resolution: IntProperty(
        name="Resolution",
        description="Texels along each side of a lightmap",
        default=512,
        min=16,
        max=16384,
        soft_max=4096,
        subtype="PIXEL",
    )
    quality: EnumProperty(
        name="Quality",
        description="How exact the light is to be: a preset of the tolerance",
        items=QUALITIES,
        get=_quality,
        set=_set_quality,
    )
    tolerance: FloatProperty(
        name="Tolerance",
        description="Mean squared error over the mean square of the light that is good enough. 0.05 is a draft, 0.01 "
        "clean to the eye, 0.001 for close-ups",
        default=0.01,
        min=1e-6,
        max=1.0,
        precision=4,
        step=0.1,
    )
    texels_per_metre: FloatProperty(
        name="Texels per Metre",
        description="Each map gets as many texels as its receiver takes for so many on each metre of it, in steps of "
        "16. 0: all have the resolution that is set",
        default=0.0,
        min=0.0,
        soft_max=1000.0,
        precision=1,
    )
    padding: IntProperty(
        name="Size",
        description="Texels that each UV island is grown by, so that no dark seam shows along its border",
        default=4,
        min=0,
        max=64,
        subtype="PIXEL",
    )
    dispersion: FloatProperty(
        name="Abbe Number",
        description="How much more water and glass bend blue than red: 55.7 is water, less is more colourful. "
        "0 bends all colours alike, in a third of the time. Objects can have their own under Glass and Metal",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        precision=1,
    )
    match_cycles: BoolProperty(
        name="Match Cycles",
        description="Divide the maps by the square of the IOR: Cycles leaves out that radiance falls by as much where "
        "rays leave the water, so that maps seen through its water are too bright. Off, they hold W/m²",
        default=False,
    )
    reuse: FloatProperty(
        name="Temporal Reuse",
        description="Share of its light that a texel keeps from frame to frame. Less noise in scenes that hardly move, "
        "but caustics that move leave trails: 0, off, is right for most",
        default=0.0,
        min=0.0,
        max=0.95,
        precision=2,
    )
    bounces: IntProperty(
        name="Bounces",
        description="Surfaces that bend or mirror light on its way over glass and metal, at most. A solid piece of "
        "glass takes two, light that goes round inside it more",
        default=6,
        min=1,
        soft_max=16,
    )
    volume: PointerProperty(
        name="Volume",
        description="A cube Empty that bounds the work: only light that enters it, and glass and metal in it, cast "
        "caustics; what stands outside only blocks light. Without one everything does",
        type=bpy.types.Object,
        poll=_is_box,
    )
    culling: EnumProperty(
        name="Culling",
        description="Sides of the volume, along its own axes, at which light that leaves it ends",
        items=CULLING,
        options={"ENUM_FLAG"},
    )
    workers: IntProperty(
        name="Workers",
        description="How many frames are solved at once, each by a process of its own. 0: as many as there are cores, "
        "as far as memory allows",
        default=0,
        min=0,
        soft_max=64,
    )
    use_scene_range: BoolProperty(
        name="Scene Frame Range", description="Bake from the scene's first frame to its last", default=True
    )
    frame_start: IntProperty(name="Start", description="First frame of the bake", default=1, min=0, max=1048574)
    frame_end: IntProperty(name="End", description="Last frame of the bake", default=48, min=0, max=1048574)
    tile: BoolProperty(
        name="Tileable",
        description="Make a map that repeats without a seam: the water is one tile of many, above a level "
        "receiver of the same size whose UV map fills the square. Suns only",
        default=False,
    )
    depth: EnumProperty(
        name="Color Depth",
        description="Precision of the OpenEXR files. What half floats cannot hold is kept in full floats all the same",
        items=DEPTHS,
        default="HALF",
    )
    output: StringProperty(
        name="Output",
        description="Folder for the lightmaps: <receiver>/caustics_####.exr, irradiance in W/m². "
        "// is the folder of the .blend file",
        default="//caustics",
        subtype="DIR_PATH",
        options=BLEND_RELATIVE,
    )
