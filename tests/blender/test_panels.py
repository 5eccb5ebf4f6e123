"""Panels: every setting and button, greyed where it has no say."""

import pytest

bpy = pytest.importorskip("bpy")

from dapple.addon.properties import _is_box  # noqa: E402
from dapple.tests.blender.quad_pool import pool  # noqa: E402
from dapple.tests.blender.test_addon import CLASSES  # noqa: E402


class Layout:
    """Stands in for UILayout: takes only what exists, and remembers it."""

    def __init__(self, seen):
        self.seen = seen
        self.enabled = True

    def prop(self, data, name, text=None, expand=False, translate=True):
        assert name in data.bl_rna.properties
        self.seen.append((name, self.enabled))

    def label(self, text, icon="NONE", translate=True):
        assert icon in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items

    def operator(self, idname, icon, depress=False):
        assert icon in bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items
        self.seen.append((bpy.ops.dapple.__getattr__(idname.removeprefix("dapple.")).get_rna_type().name, self.enabled))

    def progress(self, factor, text, translate=True):
        assert 0 <= factor <= 1 and text

    def column(self, align=False, heading="", factor=0.0):
        return Layout(self.seen)

    row = split = column


def drawn():
    seen = []
    for name in CLASSES[3:]:
        panel = bpy.types.Panel.bl_rna_get_subclass_py(name)
        assert panel.bl_category == "Dapple"
        panel.draw(Drawn(panel, seen), bpy.context)
    return seen


class Drawn:
    """A panel while it is drawn."""

    def __init__(self, panel, seen):
        self.layout, self.panel = Layout(seen), panel

    def column(self):
        return self.panel.column(self)


def test_panels_show_every_setting_and_button(empty_scene):
    names = {name for name, _ in drawn()}
    settings = {p.identifier for p in empty_scene.dapple.bl_rna.properties} - {"rna_type", "name"}
    buttons = {"Bake Frame", "Bake Animation", "Live Preview", "Use Selection", "Attach to Materials", "Detach"}
    buttons |= {"Export Maps", "Chart Methods", "Make Lightmap UVs", "Show Texel Status", "Look Through Water"}
    assert names == settings | buttons
    assert "Use Selection" not in dict(drawn_with_receivers(empty_scene))


def drawn_with_receivers(scene):
    pool(scene)
    return drawn()


def test_the_active_mesh_shows_whether_it_casts(empty_scene):
    pool(empty_scene)
    assert "caustics" not in dict(drawn())
    bpy.context.view_layer.objects.active = bpy.data.objects["Sun"]
    assert "caustics" not in dict(drawn())
    bpy.context.view_layer.objects.active = bpy.data.objects["Floor"]
    assert {("caustics", True), ("ior", True), ("abbe", True)} <= set(drawn())


def test_culling_waits_for_a_volume_which_is_a_cube(empty_scene):
    assert ("culling", False) in drawn()
    box = bpy.data.objects.new("Box", None)
    assert not _is_box(empty_scene.dapple, box)
    box.empty_display_type = "CUBE"
    assert _is_box(empty_scene.dapple, box)
    empty_scene.dapple.volume = box
    assert ("culling", True) in drawn()


def test_frame_range_is_greyed_while_the_scene_has_the_say(empty_scene):
    assert ("frame_start", False) in drawn()
    empty_scene.dapple.use_scene_range = False
    assert ("frame_start", True) in drawn()


def test_the_frame_range_that_shows_is_the_one_that_is_baked(empty_scene, monkeypatch):
    owners = {}
    monkeypatch.setattr(Layout, "prop", lambda self, data, name, **_: owners.update({name: data}))
    for owner, scenes in ((empty_scene, True), (empty_scene.dapple, False)):
        empty_scene.dapple.use_scene_range = scenes
        drawn()
        assert owners["frame_start"] == owners["frame_end"] == owner


def test_the_panel_shows_the_bake_that_runs(empty_scene):
    assert "Stop Baking" not in dict(drawn())
    bpy.context.window_manager.dapple.begin()
    assert "Stop Baking" in dict(drawn())
    bpy.context.window_manager.dapple.end()
