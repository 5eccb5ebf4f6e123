"""Lamps mean what Blender shows: bakes through water that does not bend against renders without water."""

import math

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import build_pool

SIDE = 16  # texels of the map, and pixels of the render, along each side of the floor
since_4_5 = pytest.mark.skipif(
    "exposure" not in bpy.types.PointLight.bl_rna.properties, reason="lamps have it since Blender 4.5"
)


@pytest.fixture
def pool(empty_scene, tmp_path):
    """The small pool without a lamp, its water wide and of an index of nearly 1, its floor white."""
    build_pool(empty_scene, tmp_path / "maps")
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    bpy.data.objects["Water"].scale = (3, 3, 1)
    material("Water", "ShaderNodeBsdfGlass").inputs["IOR"].default_value = 1.0001
    material("Floor", "ShaderNodeBsdfDiffuse").inputs["Color"].default_value = (1, 1, 1, 1)
    empty_scene.dapple.tolerance = 1e-5
    return empty_scene


def material(name, kind):
    """Give an object a material of one node; returns the node."""
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    made.node_tree.nodes.clear()
    node, output = made.node_tree.nodes.new(kind), made.node_tree.nodes.new("ShaderNodeOutputMaterial")
    made.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    bpy.data.objects[name].data.materials.append(made)
    return node


def lamp(kind, location=(0.3, -0.2, 3.0), rotation=(0.0, 0.0, 0.0), scale=(1.0, 1.0, 1.0), **settings):
    light = bpy.data.lights.new("Lamp", kind)
    for name, value in {"energy": 100.0, **({} if kind == "AREA" else {"shadow_soft_size": 0.0}), **settings}.items():
        setattr(light, name, value)
    thing = bpy.data.objects.new("Lamp", light)
    bpy.context.scene.collection.objects.link(thing)
    thing.location, thing.rotation_euler, thing.scale = location, rotation, scale
    return thing


def baked(scene):
    *_, last = bake(bpy.context, request_from_scene(scene, frames=(1,)))
    assert not any("left out" in warning for warning in last.warnings)
    return read_exr(request_from_scene(scene).out / "Floor/caustics_0001.exr")


def rendered(scene, path):
    """Irradiance [W/m^2] (SIDE, SIDE, 3) of the white floor without water, in Cycles, row 0 at v = 0."""
    scene.frame_set(1)
    bpy.data.objects["Water"].hide_render = True
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 2.0, (0, 0, 0.9)
    scene.camera, render = camera, scene.render
    render.engine, scene.cycles.samples, scene.cycles.max_bounces = "CYCLES", 4096, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    render.resolution_x = render.resolution_y = SIDE
    render.resolution_percentage = 100
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.image_settings.color_mode, render.filepath = "RGB", str(path)
    bpy.ops.render.render(write_still=True)
    return math.pi * read_exr(path)


def assert_alike(pool, tmp_path, rtol=2e-3):
    pool.dapple.resolution = SIDE
    ours, cycles = (np.asarray(image, float) for image in (baked(pool), rendered(pool, tmp_path / "cycles.exr")))
    np.testing.assert_allclose(ours.mean((0, 1)), cycles.mean((0, 1)), rtol=rtol)
    assert (((ours - cycles) ** 2).mean((0, 1)) < 1e-4 * cycles.mean((0, 1)) ** 2).all()


def test_a_point_lamp(pool, tmp_path):
    lamp("POINT", color=(1.0, 0.5, 0.25))
    assert_alike(pool, tmp_path)


@since_4_5
@pytest.mark.parametrize("size", [0.0, 0.02])
def test_exposure_temperature_and_power_per_area(pool, tmp_path, size):
    thing = lamp("POINT", shadow_soft_size=size, use_temperature=True, temperature=4000.0, exposure=1.0)
    thing.data.normalize = False
    assert_alike(pool, tmp_path)


@pytest.mark.parametrize("blend", [0.15, 1.0])
def test_a_spot_that_is_tilted_and_stretched(pool, tmp_path, blend):
    lamp("SPOT", (0.5, 0.0, 3.0), (0.1, 0.2, 0.5), (1.5, 1.0, 1.2), spot_size=0.5, spot_blend=blend)
    assert_alike(pool, tmp_path)


@pytest.mark.parametrize("settings", [{}, {"shape": "ELLIPSE", "size_y": 0.05}, {"spread": 1.2}])
def test_a_small_area_lamp_that_is_tilted_and_stretched(pool, tmp_path, settings):
    lamp("AREA", (0.5, 0.0, 3.0), (0.3, 0.2, 0.5), (1.5, 1.0, 1.2), **{"size": 0.02, **settings})
    assert_alike(pool, tmp_path)


@since_4_5
@pytest.mark.parametrize("shape", ["RECTANGLE", "DISK"])
def test_an_area_lamp_of_some_width_and_power_per_area(pool, tmp_path, shape):
    thing = lamp("AREA", (0.3, 0.0, 2.0), (0.2, 0.1, 0.0), (1.2, 1.0, 1.0), size=0.8, size_y=0.4, shape=shape)
    thing.data.normalize = False
    pool.dapple.tolerance = 1e-4
    assert_alike(pool, tmp_path)


def test_a_sun_and_two_lamps_at_once(pool, tmp_path):
    lamp("POINT", (0.8, 0.8, 4.0))
    lamp("SPOT", (-0.5, 0.2, 3.0), spot_size=0.9, spot_blend=0.5, color=(0.2, 1.0, 0.4))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 2.0, 0.0
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Sun", sun))
    assert_alike(pool, tmp_path)


@pytest.mark.parametrize(
    "shape",
    [
        {"shape": "SQUARE", "size": 0.5, "color": (1.0, 0.5, 0.25)},
        {"shape": "RECTANGLE", "size": 0.4, "size_y": 0.8, "spread": math.radians(100)},
        {"shape": "DISK", "size": 0.5, "spread": math.radians(60)},
        {"shape": "ELLIPSE", "size": 0.8, "size_y": 0.3},
    ],
    ids=lambda shape: shape["shape"],
)
def test_an_area_lamp_that_is_tilted_and_stretched(pool, tmp_path, shape):
    pool.dapple.tolerance = 1e-4
    thing = lamp("AREA", (0.5, 0.0, 3.0), (0.1, 0.2, 0.5), (1.5, -1.0, 1.2))
    for name, value in shape.items():
        setattr(thing.data, name, value)
    assert_alike(pool, tmp_path, 5e-3)


@since_4_5
def test_an_area_lamp_of_power_per_area(pool, tmp_path):
    pool.dapple.tolerance = 1e-4
    thing = lamp("AREA", scale=(2.0, 1.0, 1.0), use_temperature=True, temperature=4000.0, exposure=1.0)
    thing.data.normalize, thing.data.shape, thing.data.size = False, "DISK", 0.3
    assert_alike(pool, tmp_path, 5e-3)
