"""What stands in the light, and what is left out of it."""

import math

import bpy
import numpy as np
import pytest

from dapple.tests.blender.read_things import add, floor_and_sun, grid, read


@pytest.fixture
def pool(empty_scene):
    return floor_and_sun(empty_scene)


def test_what_blocks_light(pool):
    grid("Water", z=1.0)
    box = bpy.data.meshes.new("Box")
    box.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    add("Plain", box)
    add("Unrendered", box).hide_render = True
    add("Shadowless", box).visible_shadow = False
    add("Hidden", box).hide_viewport = True
    bearer = add("Bearer that does not render itself", box)
    bearer.instance_type, bearer.show_instancer_for_render = "VERTS", False
    switched_off = bpy.data.collections.new("Off")
    switched_off.hide_render = True
    pool.collection.children.link(switched_off)
    switched_off.objects.link(bpy.data.objects.new("In a collection that is off", box))
    bpy.ops.object.text_add()
    bpy.context.object.name = "Text"
    kept = bpy.data.collections.new("Kept")
    kept.objects.link(bpy.data.objects.new("Leaf", box))
    for x in (10.0, 20.0):
        instance = add(f"Instance {x:g}", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", kept
        instance.location.x, instance.scale = x, (2, 2, 2)
    scene, warnings = read()
    assert sorted(o.name for o in scene.occluders) == ["Leaf", "Leaf", "Plain", "Text"]
    leaves = sorted((o for o in scene.occluders if o.name == "Leaf"), key=lambda o: o.positions[0, 0])
    np.testing.assert_allclose(leaves[0].positions, [(10, 0, 0), (12, 0, 0), (10, 2, 0)])
    np.testing.assert_allclose(leaves[1].positions, leaves[0].positions + np.array([10.0, 0, 0]))
    assert len(next(o for o in scene.occluders if o.name == "Text").triangles) > 20
    assert warnings == ["Object 'Hidden' renders but is hidden in the viewport; it took no part in the bake."]


def test_instances_by_geometry_nodes_block_light(pool):
    grid("Water", z=1.0)
    stones = grid("Stones", n=1)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints")
    enter, leave, cube, scatter = (tree.nodes.new(kind) for kind in kinds)
    tree.links.new(enter.outputs[0], scatter.inputs["Points"])
    tree.links.new(cube.outputs[0], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], leave.inputs[0])
    stones.modifiers.new("Scatter", "NODES").node_group = tree
    scene, warnings = read()
    assert warnings == []
    centres = sorted(tuple(o.positions.mean(0).round(6)) for o in scene.occluders)
    assert centres == [(-1, -1, 0), (-1, 1, 0), (1, -1, 0), (1, 1, 0)]
    assert all(len(o.triangles) == 12 for o in scene.occluders)


def test_occluder_that_is_not_finite_is_left_out_with_a_word(pool):
    grid("Water", z=1.0)
    broken = bpy.data.meshes.new("Broken")
    broken.from_pydata([(0, 0, 0), (1, 0, 0), (0, math.nan, 0)], [], [(0, 1, 2)])
    add("Broken", broken)
    scene, warnings = read()
    assert scene.occluders == ()
    assert warnings == ["Object 'Broken' has vertices that are not numbers; it casts no shadow."]
