"""Attaching maps to materials: the light is added, the look is kept, and detaching leaves no trace."""

import math

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.show.attach import attach, detach  # noqa: E402
from dapple.tests.blender.attach_scene import (  # noqa: E402
    glowing,
    grouped,
    mixed,
    plane,
    principled,
    shader,
    state,
    surface_of,
    textured,
    two_outputs,
    without_surface,
)

MATERIALS = [principled, textured, glowing, mixed, two_outputs, without_surface]


@pytest.mark.parametrize("make", MATERIALS)
def test_detach_restores_the_node_tree(make, out):
    plane("Floor", make())
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert state() != before
    assert detach(bpy.context, ["Floor"]) == ["Floor"]
    assert state() == before


@pytest.mark.parametrize("make", MATERIALS)
def test_attaching_twice_is_attaching_once(make, out):
    plane("Floor", make())
    attach(bpy.context, ["Floor"], out)
    once = state()
    attach(bpy.context, ["Floor"], out)
    assert state() == once


@pytest.mark.parametrize("make", [principled, textured, glowing, mixed])
def test_surface_is_kept_and_light_is_added(make, out):
    material = make()
    plane("Floor", material)
    kept = surface_of(material).links[0].from_socket
    attach(bpy.context, ["Floor"], out)
    total = surface_of(material).links[0].from_node
    assert total.bl_idname == "ShaderNodeAddShader"
    assert total.inputs[0].links[0].from_socket == kept
    emission = total.inputs[1].links[0].from_node
    assert emission.inputs["Strength"].default_value == pytest.approx(1 / math.pi)


@pytest.mark.parametrize("make", [principled, glowing, mixed])
def test_albedo_is_the_value_of_the_shader(make, out):
    material = make()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.2, 0.4, 0.6))


def test_an_output_for_each_engine_takes_the_light_of_its_own_albedo(out):
    material = two_outputs()
    plane("Floor", material)
    assert attach(bpy.context, ["Floor"], out) == []
    for engine, albedo in (("EEVEE", (0.2, 0.4, 0.6)), ("CYCLES", (0.5, 0.5, 0.5))):
        total = material.node_tree.get_output_node(engine).inputs["Surface"].links[0].from_node
        product = total.inputs[1].links[0].from_node.inputs["Color"].links[0].from_node
        assert tuple(product.inputs[0].default_value) == pytest.approx(albedo)


def test_metal_takes_no_light(out):
    material = principled()
    shader(material).inputs["Metallic"].default_value = 0.75
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    strength = material.node_tree.nodes["Dapple Light"].inputs["Strength"].default_value
    assert strength == pytest.approx(0.25 / math.pi)


def test_albedo_is_read_through_the_link_that_feeds_the_shader(out):
    material = textured()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert product.inputs[0].links[0].from_socket == shader(material).inputs["Base Color"].links[0].from_socket


def test_albedo_is_found_through_a_node_group(out):
    material = grouped(colour_inside=False)
    plane("Floor", material)
    assert attach(bpy.context, ["Floor"], out) == []
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.7, 0.8, 0.9))


@pytest.mark.parametrize("make", [lambda: grouped(colour_inside=True), without_surface])
def test_white_stands_in_and_is_said_where_there_is_no_albedo(make, out):
    material = make()
    plane("Floor", material)
    notes = attach(bpy.context, ["Floor"], out)
    assert len(notes) == 1
    assert "'Floor'" in notes[0] and "white" in notes[0]
    product = material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("link", ["DATA", "OBJECT"])
def test_empty_slot_gets_a_grey_material_for_a_while(link, out):
    floor = plane("Floor")
    floor.data.materials.append(None)
    floor.material_slots[0].link = link
    before = state()
    notes = attach(bpy.context, ["Floor"], out)
    assert "grey" in notes[0]
    product = floor.material_slots[0].material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.8, 0.8, 0.8))
    detach(bpy.context)
    assert state() == before


@pytest.mark.parametrize("shared", [False, True])
def test_object_without_slots_gets_one_for_a_while(shared, out):
    floor = plane("Floor")
    if shared:
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("Twin", floor.data))
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material
    assert not shared or bpy.data.objects["Twin"].material_slots[0].material is None
    detach(bpy.context)
    assert state() == before


@pytest.mark.skipif(bpy.app.version >= (5, 0), reason="every material has nodes from Blender 5.0 on")
def test_material_without_nodes_keeps_its_colour(out):
    material = bpy.data.materials.new("Paint")
    material.diffuse_color = (0.3, 0.2, 0.1, 1.0)
    floor = plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    product = floor.material_slots[0].material.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.3, 0.2, 0.1))
    detach(bpy.context)
    assert floor.material_slots[0].material == material and not material.use_nodes


def test_a_copy_keeps_what_was_changed_in_it(out):
    floor, _ = plane("Floor", principled()), plane("Ring", bpy.data.materials["Stone"])
    attach(bpy.context, ["Floor"], out)
    copy = floor.material_slots[0].material
    shader(copy).inputs["Base Color"].default_value = (0.1, 0.1, 0.1, 1.0)
    assert attach(bpy.context, ["Floor"], out) == []
    assert floor.material_slots[0].material == copy
    product = copy.node_tree.nodes["Dapple Albedo x Irradiance"]
    assert tuple(product.inputs[0].default_value) == pytest.approx((0.1, 0.1, 0.1))
