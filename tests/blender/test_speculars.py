"""What materials cast is what their nodes say, and what Cycles shows of them."""

import math

import bpy
import numpy as np
import pytest

from dapple.kernels.casters import Glass, Mirror
from dapple.operators.read.speculars import read_specular

COLOUR = (0.25, 0.5, 0.81, 1.0)
RGB = np.array(COLOUR[:3])
GLASS = {"Base Color": COLOUR, "Transmission Weight": 1.0, "Roughness": 0.0, "IOR": 1.5}
METALLIC = bpy.app.version >= (4, 3, 0)


@pytest.fixture
def tree(empty_scene):
    """The nodes of a material "Clear": an output and nothing else."""
    material = bpy.data.materials.new("Clear")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    return material.node_tree


def node(tree, kind, values):
    made = tree.nodes.new(kind)
    for name, value in values.items():
        made.inputs[name].default_value = value
    return made


def show(tree, shader):
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return read_specular(bpy.data.materials["Clear"])


def check_glass(found, eta, transmits, reflects):
    assert isinstance(found.material, Glass)
    assert found.material.eta == eta
    np.testing.assert_allclose(found.material.transmits, transmits, atol=1e-6)
    np.testing.assert_allclose(found.material.reflects, reflects, atol=1e-6)
    np.testing.assert_array_equal(found.material.sigma_a, 0)


def check_mirror(found, f0, f90):
    assert isinstance(found.material, Mirror)
    np.testing.assert_allclose(found.material.f0, f0, atol=1e-6)
    np.testing.assert_allclose(found.material.f90, f90, atol=1e-6)


def test_principled_glass_tints_by_the_root_at_each_meeting(tree):
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", GLASS))
    check_glass(found, 1.5, np.sqrt(RGB), 1)
    assert (found.roughness, found.warnings, found.wrong) == (0.0, (), "")


def test_glass_tints_both_ways(tree):
    check_glass(show(tree, node(tree, "ShaderNodeBsdfGlass", {"Color": COLOUR, "IOR": 1.45})), 1.45, RGB, RGB)


def test_refraction_reflects_nothing(tree):
    check_glass(show(tree, node(tree, "ShaderNodeBsdfRefraction", {"Color": COLOUR, "IOR": 1.3})), 1.3, RGB, 0)


def test_principled_metal(tree):
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", {"Base Color": COLOUR, "Metallic": 1.0, "Roughness": 0}))
    check_mirror(found, RGB, 1)
    assert found.warnings == ()


def test_glossy_mirrors_alike_at_every_angle(tree):
    found = show(tree, node(tree, "ShaderNodeBsdfAnisotropic", {"Color": COLOUR, "Roughness": 0.25}))
    check_mirror(found, RGB, RGB)
    assert found.roughness == 0.25


@pytest.mark.skipif(not METALLIC, reason="this Blender has no Metallic BSDF")
def test_metallic_by_colour_and_by_index(tree):
    metal = node(tree, "ShaderNodeBsdfMetallic", {"Base Color": COLOUR, "Edge Tint": (1, 1, 1, 1)})
    found = show(tree, metal)
    check_mirror(found, RGB, 1)
    assert found.warnings == ()
    metal.inputs["Edge Tint"].default_value = (0.5, 0.5, 0.5, 1)
    (said,) = show(tree, metal).warnings
    assert "edge tint of material 'Clear' is left out" in said
    metal.fresnel_type = "PHYSICAL_CONDUCTOR"
    metal.inputs["IOR"].default_value, metal.inputs["Extinction"].default_value = (0.2, 1, 1.5), (3, 2, 0)
    found = show(tree, metal)
    check_mirror(found, [(0.64 + 9) / (1.44 + 9), 4 / 8, 0.04], 1)
    assert found.warnings == ()


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("ShaderNodeBsdfDiffuse", {}),
        ("ShaderNodeBsdfPrincipled", {}),
        ("ShaderNodeBsdfPrincipled", {"Metallic": 0.02, "Transmission Weight": 0.03}),
        ("ShaderNodeBsdfPrincipled", {**GLASS, "Alpha": 0.0}),
    ],
)
def test_what_neither_refracts_nor_mirrors(tree, kind, values):
    assert show(tree, node(tree, kind, values)) is None


def test_material_without_a_surface(tree):
    node(tree, "ShaderNodeBsdfGlass", {})
    assert read_specular(bpy.data.materials["Clear"]) is None
    assert read_specular(None) is None


def test_the_larger_part_is_taken_by_its_share_and_the_rest_said(tree):
    half = {**GLASS, "Metallic": 0.25, "Alpha": 0.8}
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", half))
    check_glass(found, 1.5, 0.6 * np.sqrt(RGB), 0.6)
    (said,) = found.warnings
    assert "'Clear' is glass by 60%" in said


def test_mixed_shaders_count_by_their_share(tree):
    mix = node(tree, "ShaderNodeMixShader", {0: 0.25})
    tree.links.new(node(tree, "ShaderNodeBsdfAnisotropic", {"Color": COLOUR}).outputs[0], mix.inputs[1])
    tree.links.new(node(tree, "ShaderNodeBsdfGlass", {}).outputs[0], mix.inputs[2])
    found = show(tree, mix)
    check_mirror(found, 0.75 * RGB, 0.75 * RGB)
    assert "a mirror by 75%" in found.warnings[0]


def test_shadow_rays_mixed_with_transparency_are_none_of_ours(tree):
    """The usual way to let light through glass in a render: transparent to shadow rays, glass to all others."""
    mix = node(tree, "ShaderNodeMixShader", {})
    tree.links.new(tree.nodes.new("ShaderNodeLightPath").outputs["Is Shadow Ray"], mix.inputs[0])
    tree.links.new(node(tree, "ShaderNodeBsdfGlass", {"Color": COLOUR, "IOR": 1.5}).outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    found = show(tree, mix)
    check_glass(found, 1.5, RGB, RGB)
    assert found.warnings == ()


def mixed_by(tree, kind, output, values, *shaders):
    """A Mix Shader of two by an output of a node of a kind."""
    mix = node(tree, "ShaderNodeMixShader", {})
    tree.links.new(node(tree, kind, values).outputs[output], mix.inputs[0])
    for k, shader in enumerate(shaders):
        tree.links.new(shader.outputs[0], mix.inputs[k + 1])
    return mix


@pytest.mark.parametrize(
    ("kind", "output", "values"),
    [
        ("ShaderNodeFresnel", 0, {"IOR": 1.5}),
        ("ShaderNodeLayerWeight", "Fresnel", {"Blend": 1 / 3}),
        ("ShaderNodeLayerWeight", "Facing", {"Blend": 0.5}),
    ],
)
def test_glass_made_by_hand_is_glass_and_what_is_varnished_is_no_mirror(tree, kind, output, values):
    """Refraction and Glossy by Fresnel: what passes is dimmed by Fresnel's share where light meets it, not before."""
    glossy = node(tree, "ShaderNodeBsdfAnisotropic", {"Roughness": 0.0})
    bends = node(tree, "ShaderNodeBsdfRefraction", {"Color": COLOUR, "IOR": 1.5})
    found = show(tree, mixed_by(tree, kind, output, values, bends, glossy))
    check_glass(found, 1.5, RGB, 0)
    assert found.warnings == ()
    diffuse = node(tree, "ShaderNodeBsdfDiffuse", {})
    assert show(tree, mixed_by(tree, kind, output, values, diffuse, glossy)) is None
    metal = show(tree, mixed_by(tree, "ShaderNodeFresnel", 0, {"IOR": 9.0}, diffuse, glossy))
    np.testing.assert_allclose(metal.material.f0, 0.64 * np.array(glossy.inputs["Color"].default_value[:3]), atol=1e-6)


def test_a_muted_node_is_passed_by_or_is_none(tree):
    glass, diffuse = node(tree, "ShaderNodeBsdfGlass", {"IOR": 1.5}), node(tree, "ShaderNodeBsdfDiffuse", {})
    mix = node(tree, "ShaderNodeMixShader", {0: 1.0})
    tree.links.new(glass.outputs[0], mix.inputs[1])
    tree.links.new(diffuse.outputs[0], mix.inputs[2])
    assert show(tree, mix) is None
    mix.mute = True  # now its first shader shows
    check_glass(show(tree, mix), 1.5, 1, 1)
    value = tree.nodes.new("ShaderNodeValue")
    value.outputs[0].default_value, value.mute = 1.7, True
    tree.links.new(value.outputs[0], glass.inputs["IOR"])
    assert "fed by nodes" in show(tree, mix).warnings[0]
    glass.mute = True
    assert show(tree, mix) is None


def test_specular_tint_colours_what_glass_reflects(tree):
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", {**GLASS, "Specular Tint": COLOUR}))
    check_glass(found, 1.5, np.sqrt(RGB), RGB)


def test_volume_absorbs(tree):
    absorption = node(tree, "ShaderNodeVolumeAbsorption", {"Color": COLOUR, "Density": 2.0})
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    tree.links.new(absorption.outputs[0], output.inputs["Volume"])
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", GLASS))
    np.testing.assert_allclose(found.material.sigma_a, 2 * (1 - RGB), atol=1e-6)


def test_what_nodes_compute_is_said(tree):
    glass = node(tree, "ShaderNodeBsdfGlass", {"Color": COLOUR})
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], glass.inputs["Color"])
    tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], glass.inputs["Normal"])
    found = show(tree, glass)
    np.testing.assert_allclose(found.material.transmits, RGB, atol=1e-6)
    assert "'Clear' is fed by nodes" in found.warnings[0]
    assert "'Clear' has a bump or normal map" in found.warnings[1]


def test_a_value_feeds_a_colour_and_a_colour_a_value(tree):
    glass = node(tree, "ShaderNodeBsdfGlass", {})
    tree.links.new(node(tree, "ShaderNodeMixShader", {}).inputs[0], tree.nodes.new("ShaderNodeValue").outputs[0])
    value, colour = tree.nodes.new("ShaderNodeValue"), tree.nodes.new("ShaderNodeRGB")
    value.outputs[0].default_value, colour.outputs[0].default_value = 0.5, (1.0, 2.0, 1.5, 1.0)
    tree.links.new(value.outputs[0], glass.inputs["Color"])
    tree.links.new(colour.outputs[0], glass.inputs["IOR"])
    found = show(tree, glass)
    check_glass(found, pytest.approx(0.2126 + 2 * 0.7152 + 1.5 * 0.0722, rel=1e-5), 0.5, 0.5)


def test_a_coat_is_said(tree):
    (said,) = show(tree, node(tree, "ShaderNodeBsdfPrincipled", {**GLASS, "Coat Weight": 0.5})).warnings
    assert said == "The coat or thin film of material 'Clear' is left out of its caustics."


@pytest.mark.skipif(bpy.app.version < (5, 2, 0), reason="this Blender has no thin walls")
def test_a_thin_wall_bends_nothing(tree):
    found = show(tree, node(tree, "ShaderNodeBsdfPrincipled", {**GLASS, "Thin Wall": True}))
    assert found.wrong.startswith("Material 'Clear' is a thin wall")


@pytest.mark.parametrize("ior", [0.75, 4.5])
def test_impossible_index(tree, ior):
    found = show(tree, node(tree, "ShaderNodeBsdfGlass", {"IOR": ior}))
    assert found.wrong.startswith(f"Material 'Clear' has IOR {ior} and casts no caustics; set it between 1 and 4")


def seen_by_cycles(tree, shader, behind):
    """Radiance (3,) of a plane of the material seen straight on, with a surface of radiance 1 behind or before it."""
    scene = bpy.context.scene
    material = bpy.data.materials["Clear"]
    show(tree, shader)
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 1024
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 4
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 0.1
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location.z = 1.0
    scene.collection.objects.link(scene.camera)
    lamp = bpy.data.materials.new("Lamp")
    if bpy.app.version < (5, 0, 0):
        lamp.use_nodes = True
    lamp.node_tree.nodes.clear()
    ends = (lamp.node_tree.nodes.new("ShaderNodeEmission"), lamp.node_tree.nodes.new("ShaderNodeOutputMaterial"))
    lamp.node_tree.links.new(ends[0].outputs[0], ends[1].inputs[0])
    for made, height in ((material, 0.0), (lamp, -1.0 if behind else 2.0)):
        bpy.ops.mesh.primitive_plane_add(size=50.0, location=(0, 0, height))
        bpy.context.object.data.materials.append(made)
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = bpy.app.tempdir + "seen.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean(0)


@pytest.mark.parametrize("behind", [True, False])
@pytest.mark.parametrize("kind", ["ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlass"])
def test_colours_are_those_of_cycles(tree, kind, behind):
    values = GLASS if kind == "ShaderNodeBsdfPrincipled" else {"Color": COLOUR, "Roughness": 0.0, "IOR": 1.5}
    shader = node(tree, kind, values)
    glass = show(tree, shader).material
    fresnel = ((1.5 - 1) / (1.5 + 1)) ** 2
    expected = (1 - fresnel) * glass.transmits if behind else fresnel * glass.reflects
    deviation = math.sqrt(fresnel * (1 - fresnel) / (16 * 1024))  # Cycles chooses the branch by chance
    assert np.abs(seen_by_cycles(tree, shader, behind) - expected).max() < 6 * deviation
