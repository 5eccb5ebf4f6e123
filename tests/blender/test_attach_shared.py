"""Attaching maps to what others show too - materials, meshes, libraries, duplicates: nobody else's look changes."""

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.errors import DappleError  # noqa: E402
from dapple.operators.show.attach import attach, detach  # noqa: E402
from dapple.tests.blender.attach_scene import dump, plane, principled, state  # noqa: E402


def test_material_that_others_show_is_not_touched(out):
    material = principled()
    floor, wall, ring = plane("Floor", material), plane("Wall", material), plane("Ring", material)
    tree = dump(material.node_tree)
    before = state()
    notes = attach(bpy.context, ["Floor", "Wall"], out)
    assert dump(material.node_tree) == tree
    assert ring.material_slots[0].material == material
    assert len({o.material_slots[0].material.name for o in (floor, wall, ring)}) == 3
    images = [o.material_slots[0].material.node_tree.nodes["Dapple Irradiance"].image.filepath for o in (floor, wall)]
    assert "Floor" in images[0] and "Wall" in images[1]
    assert len(notes) == 2
    detach(bpy.context)
    assert state() == before


def test_two_receivers_that_share_a_material_keep_it_alive(out):
    plane("Floor", principled()), plane("Wall", bpy.data.materials["Stone"])
    attach(bpy.context, ["Floor", "Wall"], out)
    bpy.data.orphans_purge()
    detach(bpy.context, ["Floor"])
    assert bpy.data.objects["Floor"].material_slots[0].material == bpy.data.materials["Stone"]
    assert "Dapple Irradiance" in bpy.data.objects["Wall"].material_slots[0].material.node_tree.nodes


def test_mesh_that_another_object_shows_is_not_touched(out):
    floor = plane("Floor", principled())
    twin = bpy.data.objects.new("Twin", floor.data)
    bpy.context.scene.collection.objects.link(twin)
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert twin.material_slots[0].material == bpy.data.materials["Stone"]
    assert floor.material_slots[0].link == "OBJECT"
    assert floor.material_slots[0].material != bpy.data.materials["Stone"]
    detach(bpy.context)
    assert state() == before


def test_linked_material_is_copied(out, tmp_path):
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {principled()})
    bpy.data.materials.remove(bpy.data.materials["Stone"])
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.materials = ["Stone"]
    floor = plane("Floor", wanted.materials[0])
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material.library is None
    detach(bpy.context)
    assert state() == before


def test_override_of_a_linked_object_shows_its_map(out, tmp_path):
    library = tmp_path / "library.blend"
    floor = plane("Floor", principled())
    bpy.data.libraries.write(str(library), {floor})
    bpy.data.batch_remove([floor, floor.data, bpy.data.materials["Stone"]])
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Floor"]
    linked = wanted.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    with pytest.raises(DappleError, match="library override"):
        attach(bpy.context, ["Floor"], out)
    floor = linked.override_create(remap_local_usages=True)
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert "Dapple Irradiance" in floor.material_slots[0].material.node_tree.nodes
    detach(bpy.context)
    assert state() == before


def test_material_of_a_modifier_is_said(out):
    floor, marble = plane("Floor", principled()), principled("Marble")
    group = bpy.data.node_groups.new("Set", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    enter, leave = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    node = group.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = marble
    group.links.new(enter.outputs[0], node.inputs["Geometry"])
    group.links.new(node.outputs[0], leave.inputs[0])
    floor.modifiers.new("Set", "NODES").node_group = group
    notes = attach(bpy.context, ["Floor"], out)
    assert len(notes) == 1 and "'Marble'" in notes[0]


def test_two_slots_of_one_material_are_one_edit(out):
    floor = plane("Floor", principled())
    floor.data.materials.append(bpy.data.materials["Stone"])
    before = state()
    attach(bpy.context, ["Floor"], out)
    assert floor.material_slots[0].material == floor.material_slots[1].material
    assert sum("dapple" in n for n in floor.material_slots[0].material.node_tree.nodes) == 6
    detach(bpy.context)
    assert state() == before


def test_duplicate_of_a_receiver_gets_its_own_map(out):
    floor = plane("Floor", principled())
    attach(bpy.context, ["Floor"], out)
    wall = floor.copy()
    wall.name = "Wall"
    bpy.context.scene.collection.objects.link(wall)
    attach(bpy.context, ["Wall", "Floor"], out)
    for obj in (floor, wall):
        nodes = obj.material_slots[0].material.node_tree.nodes
        assert [n.image.name for n in nodes if n.type == "TEX_IMAGE"] == [f"Dapple {obj.name}"]
    detach(bpy.context)
    assert [m.name for m in bpy.data.materials] == ["Stone"]
    assert not any("dapple" in n for n in bpy.data.materials["Stone"].node_tree.nodes)


@pytest.mark.parametrize("make", [principled, lambda: None])
def test_duplicate_of_a_receiver_with_a_copy_goes_back_to_the_original(make, out):
    floor = plane("Floor", make())
    if not floor.material_slots:
        floor.data.materials.append(None)
    original = floor.material_slots[0].material
    plane("Ring", original)
    attach(bpy.context, ["Floor"], out)
    wall = floor.copy()
    wall.name, wall.data = "Wall", floor.data.copy()
    bpy.context.scene.collection.objects.link(wall)
    attach(bpy.context, ["Wall"], out)
    detach(bpy.context)
    assert floor.material_slots[0].material == wall.material_slots[0].material == original
    assert len(bpy.data.materials) == (1 if original else 0)
