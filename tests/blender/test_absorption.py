"""The volume that an artist gave the water is what absorbs, as much as Cycles makes it absorb."""

import math

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.read.absorption import read_sigma_a
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import build_pool

COLOUR, TINT = (0.2, 0.6, 0.9, 1.0), (0.1, 0.5, 0.8, 1.0)
ABSORPTION = "ShaderNodeVolumeAbsorption"
NODES = {
    ABSORPTION: {"Color": COLOUR, "Density": 0.7},
    "ShaderNodeVolumePrincipled": {"Color": (0.0, 0.0, 0.0, 1.0), "Absorption Color": TINT, "Density": 0.5},
    "ShaderNodeVolumeCoefficients": {"Absorption Coefficients": (0.1, 0.3, 0.8), "Scatter Coefficients": (0, 0, 0)},
}
KINDS = [kind for kind in NODES if hasattr(bpy.types, kind)]  # coefficients: since Blender 4.3


@pytest.fixture
def slab(empty_scene):
    """A cube of 8 x 8 x 0.5 m with a transparent surface."""
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    cube = bpy.context.object
    cube.scale = (8.0, 8.0, 0.5)
    made = bpy.data.materials.new("Blue")
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    made.node_tree.nodes.clear()
    output = made.node_tree.nodes.new("ShaderNodeOutputMaterial")
    clear = made.node_tree.nodes.new("ShaderNodeBsdfTransparent")
    made.node_tree.links.new(clear.outputs[0], output.inputs["Surface"])
    cube.data.materials.append(made)
    return cube


def volume(tree, kind, settings=None):
    node = tree.nodes.new(kind)
    for name, value in (settings or NODES[kind]).items():
        node.inputs[name].default_value = value
    return node


def feed(slab, node):
    tree = slab.data.materials[0].node_tree
    tree.links.new(node.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])


def read(slab):
    return read_sigma_a(slab.evaluated_get(bpy.context.evaluated_depsgraph_get()))


def through(scene, path):
    """What Cycles lets through (3,) of a white background behind the slab, seen straight on."""
    world = bpy.data.worlds.new("White")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.world = world
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.1, (0, 0, 3)
    scene.camera, render = camera, scene.render
    render.engine, scene.cycles.samples = "CYCLES", 16
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    render.resolution_x = render.resolution_y = 4
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode, render.filepath = "RGB", str(path)
    bpy.ops.render.render(write_still=True)
    return read_exr(path).mean((0, 1))


@pytest.mark.parametrize("kind", KINDS)
def test_a_slab_in_cycles_absorbs_what_is_read(slab, tmp_path, kind):
    feed(slab, volume(slab.data.materials[0].node_tree, kind))
    sigma_a, warnings = read(slab)
    assert warnings == []
    assert len(set(sigma_a)) == 3
    seen = through(bpy.context.scene, tmp_path / "slab.exr")
    np.testing.assert_allclose(np.exp(-0.5 * sigma_a), seen, rtol=2e-3)


def test_no_volume_absorbs_nothing(slab):
    sigma_a, warnings = read(slab)
    assert not sigma_a.any() and warnings == []
    slab.data.materials.clear()
    assert not read(slab)[0].any()


def test_two_volumes_add_and_mixed_ones_share(slab):
    tree = slab.data.materials[0].node_tree
    nodes = [volume(tree, ABSORPTION, {"Color": (0, 0, 1, 1), "Density": d}) for d in (0.2, 0.4)]
    for kind, share in (("ShaderNodeAddShader", (1, 1)), ("ShaderNodeMixShader", (0.75, 0.25))):
        joint = tree.nodes.new(kind)
        for node, socket in zip(nodes, [s for s in joint.inputs if s.type == "SHADER"], strict=True):
            tree.links.new(node.outputs[0], socket)
        if kind == "ShaderNodeMixShader":
            joint.inputs[0].default_value = 0.25
        feed(slab, joint)
        expected = 0.2 * share[0] + 0.4 * share[1]
        np.testing.assert_allclose(read(slab)[0], [expected, expected, 0], rtol=1e-5)


def test_scattering_and_computed_sockets_are_said(slab):
    tree = slab.data.materials[0].node_tree
    node = volume(tree, "ShaderNodeVolumePrincipled", {"Color": (0.5, 0.5, 0.5, 1), "Density": 0.1})
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], node.inputs["Density"])
    feed(slab, node)
    sigma_a, warnings = read(slab)
    np.testing.assert_allclose(sigma_a, 0.05, rtol=1e-5)
    assert len(warnings) == 2
    assert "'Blue' is fed by nodes" in warnings[0]
    assert "'Blue' scatters light" in warnings[1]


def test_the_bake_absorbs_along_the_bent_way(empty_scene, tmp_path):
    """Sun at 30 degrees over 1 m of flat water: exp(-sigma_a / cos_t) of what clear water lets through."""
    build_pool(empty_scene, tmp_path)
    bpy.data.objects["Water"].scale = (3, 3, 1)
    bpy.data.objects["Sun"].rotation_euler = (math.radians(30), 0, 0)
    made = bpy.data.materials.new("Blue")
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    made.node_tree.nodes["Principled BSDF"].inputs["IOR"].default_value = 1.333
    bpy.data.objects["Water"].data.materials.append(made)
    feed(bpy.data.objects["Water"], volume(made.node_tree, ABSORPTION))
    *_, last = bake(bpy.context, request_from_scene(empty_scene, frames=(1,)))
    assert last.warnings == ()
    sigma_a = 0.7 * (1 - np.array(COLOUR[:3]))
    cos_t = math.cos(math.asin(math.sin(math.radians(30)) / 1.333))
    image = read_exr(request_from_scene(empty_scene).out / "Floor/caustics_0001.exr")
    np.testing.assert_allclose(image[4:-4, 4:-4].mean((0, 1)), 0.8475 * np.exp(-sigma_a / cos_t), rtol=1e-3)
