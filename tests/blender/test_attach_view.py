"""What Attach says of water that EEVEE does not look through."""

from types import SimpleNamespace

import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.show import attach_view  # noqa: E402
from dapple.operators.show.attach import attach  # noqa: E402
from dapple.operators.show.attach_view import look_through, unseen  # noqa: E402
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


def test_the_button_turns_on_both_and_waits_for_maps(water, empty_scene, out):
    plane("Floor", principled())
    with pytest.raises(RuntimeError, match="attach them first"):
        bpy.ops.dapple.look_through()
    attach(bpy.context, ["Floor"], out, ["Water"])
    assert bpy.ops.dapple.look_through() == {"FINISHED"}
    assert empty_scene.eevee.use_raytracing and water.data.materials[0].use_raytrace_refraction
    with pytest.raises(RuntimeError, match="Nothing hides"):
        bpy.ops.dapple.look_through()


class Linked:
    """Stands in for a material of another file."""

    name, library, use_raytrace_refraction = "Far", "far.blend", False


def test_a_linked_material_is_named(water, empty_scene, monkeypatch):
    """What cannot be changed is said, and the rest turned on."""
    linked = Linked()
    monkeypatch.setattr(attach_view, "_is_glass", lambda material: material is not None)
    far = SimpleNamespace(material_slots=[SimpleNamespace(material=linked)])
    (note,) = look_through(empty_scene, [water, far])
    assert "turn on Raytraced Transmission (material 'Far')" in note
    assert water.data.materials[0].use_raytrace_refraction and not linked.use_raytrace_refraction


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
