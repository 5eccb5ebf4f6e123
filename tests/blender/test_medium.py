"""The IOR that an artist set is the one that bends the light."""

import bpy
import pytest

from dapple.operators.errors import DappleError
from dapple.operators.read.medium import read_eta


@pytest.fixture
def water(empty_scene):
    """An object with one material, whose nodes are an output and nothing else."""
    mesh = bpy.data.meshes.new("Water")
    thing = bpy.data.objects.new("Water", mesh)
    empty_scene.collection.objects.link(thing)
    material = bpy.data.materials.new("Blue")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    mesh.materials.append(material)
    return thing


def tree_of(water):
    return water.data.materials[0].node_tree


def shader(tree, kind, ior):
    node = tree.nodes.new(kind)
    node.inputs["IOR"].default_value = ior
    return node


def surface(tree):
    return next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]


def evaluated(water):
    return water.evaluated_get(bpy.context.evaluated_depsgraph_get())


@pytest.mark.parametrize("kind", ["ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"])
def test_node_that_refracts(water, kind):
    tree = tree_of(water)
    tree.links.new(shader(tree, kind, 1.36).outputs[0], surface(tree))
    eta, warnings = read_eta(evaluated(water))
    assert eta == 1.36
    assert warnings == []


def test_nothing_that_refracts_is_water(water):
    tree = tree_of(water)
    shader(tree, "ShaderNodeBsdfGlass", 1.5)  # not connected
    assert read_eta(evaluated(water)) == (1.333, [])
    water.data.materials.clear()
    assert read_eta(evaluated(water)) == (1.333, [])
    water.data.materials.append(None)
    assert read_eta(evaluated(water)) == (1.333, [])


def test_muted_link_does_not_count(water):
    tree = tree_of(water)
    tree.links.new(shader(tree, "ShaderNodeBsdfGlass", 1.5).outputs[0], surface(tree)).is_muted = True
    assert read_eta(evaluated(water)) == (1.333, [])


def test_behind_mix_add_and_reroute(water):
    tree = tree_of(water)
    glass = shader(tree, "ShaderNodeBsdfGlass", 1.35)
    reroute, add, mix = (tree.nodes.new(k) for k in ("NodeReroute", "ShaderNodeAddShader", "ShaderNodeMixShader"))
    tree.links.new(glass.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], add.inputs[1])
    tree.links.new(add.outputs[0], mix.inputs[2])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], surface(tree))
    assert read_eta(evaluated(water))[0] == pytest.approx(1.35)


def test_through_a_group_with_its_ior_outside(water):
    inner = bpy.data.node_groups.new("Sea", "ShaderNodeTree")
    inner.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    inner.interface.new_socket("Bend", in_out="INPUT", socket_type="NodeSocketFloat")
    inner.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    enter, leave = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    glass = shader(inner, "ShaderNodeBsdfGlass", 1.9)
    inner.links.new(enter.outputs["Bend"], glass.inputs["IOR"])
    inner.links.new(glass.outputs[0], leave.inputs["Surface"])
    tree = tree_of(water)
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    group.inputs["Thickness"].default_value, group.inputs["Bend"].default_value = 9.0, 1.34
    tree.links.new(group.outputs[0], surface(tree))
    assert read_eta(evaluated(water))[0] == pytest.approx(1.34)
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value = 1.32
    tree.links.new(value.outputs[0], group.inputs["Bend"])
    assert read_eta(evaluated(water))[0] == pytest.approx(1.32)


def test_ior_that_nodes_compute_is_said(water):
    tree = tree_of(water)
    glass = shader(tree, "ShaderNodeBsdfGlass", 1.33)
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], glass.inputs["IOR"])
    tree.links.new(glass.outputs[0], surface(tree))
    eta, warnings = read_eta(evaluated(water))
    assert eta == pytest.approx(1.33)
    assert len(warnings) == 1
    assert "'Blue' is fed by nodes" in warnings[0]


def test_glass_in_place_of_water_is_said(water):
    tree = tree_of(water)
    tree.links.new(shader(tree, "ShaderNodeBsdfPrincipled", 1.5).outputs[0], surface(tree))
    eta, warnings = read_eta(evaluated(water))
    assert eta == pytest.approx(1.5)
    assert len(warnings) == 1
    assert "IOR 1.5 of material 'Blue'; water's is 1.333" in warnings[0]


def test_animated_ior_is_that_of_the_frame(water):
    tree = tree_of(water)
    glass = shader(tree, "ShaderNodeBsdfGlass", 1.3)
    tree.links.new(glass.outputs[0], surface(tree))
    glass.inputs["IOR"].keyframe_insert("default_value", frame=1)
    glass.inputs["IOR"].default_value = 1.35
    glass.inputs["IOR"].keyframe_insert("default_value", frame=2)
    for frame, expected in ((1, 1.3), (2, 1.35)):
        bpy.context.scene.frame_set(frame)
        assert read_eta(evaluated(water))[0] == pytest.approx(expected)


@pytest.mark.parametrize("ior", [0.9, 1.0, 4.5])
def test_impossible_ior(water, ior):
    tree = tree_of(water)
    tree.links.new(shader(tree, "ShaderNodeBsdfRefraction", ior).outputs[0], surface(tree))
    with pytest.raises(DappleError, match=r"'Water' has IOR .* in its material 'Blue'; set it between 1.0001 and 4"):
        read_eta(evaluated(water))
