"""What Attach says of water that EEVEE does not look through."""

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.show.attach_view import unseen  # noqa: E402
from dapple.tests.blender.attach_scene import plane, principled, shader  # noqa: E402


@pytest.fixture
def water(empty_scene):
    """Clear water, under an EEVEE that traces no rays, and so is Blender's own start."""
    water = plane("Water", principled("Clear"))
    shader(water.data.materials[0]).inputs["Transmission Weight"].default_value = 1.0
    shader(water.data.materials[0]).inputs["Roughness"].default_value = 0.0
    empty_scene.render.engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
    empty_scene.eevee.use_raytracing = False
    return water


def test_it_names_each_switch_that_is_off_and_no_other(water, empty_scene):
    assert not water.data.materials[0].use_raytrace_refraction
    (note,) = unseen(empty_scene, [water])
    assert "turn on Raytracing (render) and Raytraced Transmission (material 'Clear')" in note
    empty_scene.eevee.use_raytracing = True
    (note,) = unseen(empty_scene, [water])
    assert "turn on Raytraced Transmission" in note
    water.data.materials[0].use_raytrace_refraction = True
    assert unseen(empty_scene, [water]) == []


def test_cycles_looks_through_water_as_it_is(water, empty_scene):
    empty_scene.render.engine = "CYCLES"
    assert unseen(empty_scene, [water]) == []


def test_a_blended_surface_is_left_alone(water, empty_scene):
    water.data.materials[0].surface_render_method = "BLENDED"
    assert unseen(empty_scene, [water]) == []


def test_metal_and_objects_without_material_hide_nothing_that_could_be_seen(empty_scene, water):
    metal = plane("Ring", principled("Gold"))
    shader(metal.data.materials[0]).inputs["Metallic"].default_value = 1.0
    shader(metal.data.materials[0]).inputs["Roughness"].default_value = 0.0
    assert unseen(empty_scene, [metal, plane("Bare")]) == []
