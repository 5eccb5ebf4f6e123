"""The maps that are attached: the sequence, what is missing, and the light that EEVEE makes of them."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.errors import DappleError  # noqa: E402
from dapple.operators.maps.write import map_path, write_exr  # noqa: E402
from dapple.operators.show.attach import attach, detach, refresh  # noqa: E402
from dapple.tests.blender import shown_waters  # noqa: E402
from dapple.tests.blender.attach_scene import plane, principled, shader, state, surface_of, without_surface  # noqa: E402

RADIANCE = 0.5 / math.pi


def test_refresh_reads_new_maps_and_leaves_the_rest(out):
    material = principled()
    plane("Floor", material), plane("Wall", principled("Paint"))
    attach(bpy.context, ["Floor"], out)
    nodes = material.node_tree.nodes
    nodes["Dapple Light"].inputs["Strength"].default_value = 7.0
    write_exr(map_path(out, "Floor", 9), np.full((4, 4, 3), 9.0))
    refresh(["Floor", "Wall"], out)
    assert nodes["Dapple Irradiance"].image_user.frame_duration == 7
    assert nodes["Dapple Light"].inputs["Strength"].default_value == 7.0
    assert not any("dapple" in n for n in bpy.data.materials["Paint"].node_tree.nodes)
    assert [i.source for i in bpy.data.images] == ["SEQUENCE"]


def test_map_is_a_linear_sequence_on_the_baked_uv_map(out):
    material = principled()
    plane("Floor", material)
    attach(bpy.context, ["Floor"], out)
    nodes = material.node_tree.nodes
    texture = nodes["Dapple Irradiance"]
    assert texture.image.source == "SEQUENCE"
    assert texture.image.colorspace_settings.name == "Non-Color"
    assert texture.image_user.use_auto_refresh
    assert nodes["Dapple UV Map"].uv_map == "Bake"
    assert nodes["Dapple UV Map"].outputs["UV"] == texture.inputs["Vector"].links[0].from_socket


def test_maps_of_another_folder_take_the_place_of_the_first(out, tmp_path):
    plane("Floor", principled())
    attach(bpy.context, ["Floor"], out)
    write_exr(map_path(tmp_path / "second", "Floor", 8), np.ones((4, 4, 3)))
    attach(bpy.context, ["Floor"], tmp_path / "second")
    (image,) = bpy.data.images
    assert image.filepath == str(map_path(tmp_path / "second", "Floor", 8))
    assert image.source == "FILE"


def test_missing_frames_are_said(out):
    map_path(out, "Floor", 4).unlink()
    plane("Floor", principled())
    assert "1 frame(s) from 4" in attach(bpy.context, ["Floor"], out)[0]


@pytest.mark.parametrize("name", ["Roof", "Nothing"])
def test_nothing_changes_where_a_map_or_an_object_is_missing(name, out):
    plane("Floor", principled()), plane("Roof", principled())
    before = state()
    with pytest.raises(DappleError, match=name):
        attach(bpy.context, ["Floor", name], out)
    assert state() == before


def test_water_casts_a_whole_shadow_while_maps_are_attached(out):
    plane("Floor", principled())
    glass = principled("Glass")
    water = plane("Water", glass, height=1.0)
    glass.use_backface_culling_shadow = True
    water.visible_shadow = False
    before = state()
    for _ in range(2):
        attach(bpy.context, ["Floor"], out, ["Water"])
    assert water.visible_shadow
    assert not glass.use_transparent_shadow and not glass.use_backface_culling_shadow
    detach(bpy.context)
    assert state() == before
    assert glass.use_backface_culling_shadow


@pytest.mark.parametrize("build", [shown_waters.collection_instance, shown_waters.linked_collection_instance])
def test_what_an_empty_shows_as_water_casts_the_shadow(out, tmp_path, build):
    """The water inside, unless it is of a library, which cannot be changed."""
    plane("Floor", principled())
    (name,) = build(bpy.context.scene, tmp_path)
    (pond,) = bpy.data.objects[name].instance_collection.objects
    if not pond.library:
        pond.visible_shadow = False
    attach(bpy.context, ("Floor",), out, (name,))
    assert pond.visible_shadow
    detach(bpy.context)
    assert pond.visible_shadow == bool(pond.library)


def test_sun_without_a_shadow_is_said(out):
    plane("Floor", principled()), plane("Water", height=1.0)
    sun(2.0).data.use_shadow = False
    notes = attach(bpy.context, ["Floor"], out, ["Water"])
    assert len(notes) == 1 and "'Sun'" in notes[0]


def cycles(scene, samples=16):
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = samples, False, False


@pytest.mark.parametrize("shadow_caustics", [False, True])
def test_cycles_shows_the_map_in_watts_and_its_own_caustics_not_beside_it(shadow_caustics, out, tmp_path):
    """Cycles finds the sun through the water by itself, by rays that diffuse surfaces send out, or where these
    are on by its shadow caustics: without what `attach` does to the water the floor has 1.3 W/m^2 more."""
    scene = bpy.context.scene
    floor = plane("Floor", diffuse())
    lamp, clear = sun(3.0), principled("Glass", (1.0, 1.0, 1.0, 1.0))
    lamp.data.angle, lamp.rotation_euler.x = math.radians(20), 0.5
    for name, value in (("Transmission Weight", 1.0), ("Roughness", 0.0)):
        shader(clear).inputs[name].default_value = value
    water = plane("Water", clear, height=1.0, size=6.0)
    flags = (
        (water.cycles, "is_caustics_caster"),
        (floor.cycles, "is_caustics_receiver"),
        (lamp.data.cycles, "is_caustics_light"),
    )
    for holder, flag in flags:
        setattr(holder, flag, shadow_caustics)
    look_at_the_floor(scene)
    cycles(scene)
    picture = tmp_path / "view.exr"
    alone, before = radiance(scene, picture), state()
    attach(bpy.context, ["Floor"], out, ["Water"])
    scene.frame_set(4)
    assert radiance(scene, picture) == pytest.approx(4.0 * RADIANCE, rel=0.003)
    assert shadow_caustics or alone > 1.0 * RADIANCE
    detach(bpy.context)
    assert state() == before


def sun(strength):
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy = strength
    obj = bpy.data.objects.new("Sun", lamp)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def look_at_the_floor(scene):
    """An orthographic camera under the water, and a render without samples, world or display transform to speak of."""
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 1.0
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location.z = 0.5
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    scene.eevee.taa_render_samples = 8
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"


def radiance(scene, path):
    """Render and return the mean of all pixels."""
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(16 * 16 * 4, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)[:, :3].mean()


def diffuse():
    material = without_surface()
    node = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    material.node_tree.links.new(node.outputs[0], surface_of(material))
    return material


def test_eevee_shows_the_map_in_watts_and_the_sun_not_twice(out, tmp_path):
    """A floor of albedo 0.5 under E W/m^2 has a radiance of 0.5 / pi E, be it from a bare Sun or from the map."""
    scene = bpy.context.scene
    plane("Floor", diffuse())
    sun(3.0)
    look_at_the_floor(scene)
    picture = tmp_path / "view.exr"
    bare = radiance(scene, picture)
    assert bare == pytest.approx(3.0 * RADIANCE, rel=0.01)

    glass = principled("Glass")
    shader(glass).inputs["Alpha"].default_value = 0.1
    plane("Water", glass, height=1.0, size=6.0)
    attach(bpy.context, ["Floor"], out, ["Water"])
    # Before the range and after it the sequence repeats.
    for frame, value in ((3, 3.0), (5, 5.0), (2, 5.0), (6, 3.0)):
        scene.frame_set(frame)
        assert radiance(scene, picture) == pytest.approx(value * RADIANCE, rel=0.01)

    for frame in (3, 4, 5):
        write_exr(map_path(out, "Floor", frame), np.zeros((4, 4, 3)))
    refresh(["Floor"], out)
    assert radiance(scene, picture) < 0.005 * bare
