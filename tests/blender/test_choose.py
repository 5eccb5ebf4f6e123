"""Water and receivers that nobody set: from Cycles' flags, and from the selection."""

import bpy
import pytest

from dapple.operators.bake.bake import request_from_scene
from dapple.operators.buttons.choose import choose, wants_choice
from dapple.operators.errors import DappleError
from dapple.tests.blender.attach_scene import plane, principled, shader


def glassy(name):
    material = principled(name)
    shader(material).inputs["Transmission Weight"].default_value = 1.0
    shader(material).inputs["Roughness"].default_value = 0.0
    return material


def ball(name, material):
    bpy.ops.mesh.primitive_uv_sphere_add(location=(0, 0, 5))
    bpy.context.object.name = name
    bpy.context.object.data.materials.append(material)


def select(*names):
    for obj in bpy.data.objects:
        obj.select_set(obj.name in names)


@pytest.fixture
def scene(empty_scene, tmp_path):
    """A floor, a wall that stands higher than the water, and water of glass."""
    plane("Floor"), plane("Wall", height=2.0), plane("Water", glassy("Glass"), height=1.0)
    empty_scene.dapple.output = str(tmp_path)
    return empty_scene


def test_what_lets_light_through_is_the_water(scene):
    select("Floor", "Wall", "Water")
    said = choose(bpy.context)
    assert scene.dapple.water.name == "Water"
    assert request_from_scene(scene).receivers == ("Floor", "Wall")
    assert all(f"'{name}'" in said for name in ("Floor", "Wall", "Water", "Caustics Receivers"))
    # They stay where they were.
    assert "Floor" in scene.collection.objects


def test_the_highest_is_the_water_where_nothing_lets_light_through(scene):
    select("Floor", "Wall")
    choose(bpy.context)
    assert (scene.dapple.water.name, request_from_scene(scene).receivers) == ("Wall", ("Floor",))


def test_a_ball_of_glass_casts_and_is_no_water(scene):
    ball("Ball", glassy("Crystal"))
    select("Floor", "Ball")
    said = choose(bpy.context)
    assert scene.dapple.water is None and "glass" in said
    assert request_from_scene(scene).receivers == ("Floor",)


def test_a_collection_of_just_these_is_taken_as_it_is(scene):
    own = bpy.data.collections.new("Basin")
    scene.collection.children.link(own)
    own.objects.link(bpy.data.objects["Floor"])
    select("Floor", "Water")
    choose(bpy.context)
    assert scene.dapple.receivers == own


def test_nothing_changes_where_no_receiver_is_left(scene):
    select("Water")
    with pytest.raises(DappleError, match="Select what the light falls on"):
        choose(bpy.context)
    assert wants_choice(scene) and len(bpy.data.collections) == 0


def test_cycles_flag_says_who_receives(scene):
    with pytest.raises(DappleError, match="Receive Shadow Caustics"):
        request_from_scene(scene)
    scene.dapple.water = bpy.data.objects["Water"]
    for name in ("Floor", "Water"):
        bpy.data.objects[name].cycles.is_caustics_receiver = True
    assert request_from_scene(scene).receivers == ("Floor",)
    assert bpy.ops.dapple.bake_frame.poll() and bpy.ops.dapple.attach.poll()


def test_first_press_needs_only_the_selection(scene, tmp_path):
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    scene.collection.objects.link(sun)
    scene.dapple.resolution = 16
    select("Floor", "Water")
    assert bpy.ops.dapple.bake_frame() == {"FINISHED"}
    assert (tmp_path / "Floor" / "caustics_0001.exr").exists()
    assert scene.dapple.water.name == "Water"


def test_button_says_what_to_select(scene):
    select("Floor")
    with pytest.raises(RuntimeError, match="Select the water"):
        bpy.ops.dapple.choose()
    select("Floor", "Water")
    assert bpy.ops.dapple.choose() == {"FINISHED"}
