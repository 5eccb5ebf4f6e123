"""Who casts and who only blocks: by material, by what was asked, triangle by triangle, under any transform."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from dapple.kernels.casters import Glass, Mirror
from dapple.operators.errors import DappleError
from dapple.operators.read.casters import caster_names
from dapple.tests.blender.glass_things import ball, dry_floor, material, read
from dapple.tests.blender.small_pool import add_grid


@pytest.fixture
def scene(empty_scene, tmp_path):
    return dry_floor(empty_scene, tmp_path)


def test_glass_without_water_is_a_scene(scene):
    ball("Ball", material("Clear"))
    found, warnings = read()
    assert warnings == []
    assert len(found.water.triangles) == 0
    (caster,) = found.casters
    assert (caster.name, found.occluders) == ("Ball", ())
    assert isinstance(caster.material, Glass)
    assert caster.material.eta == 1.5


def test_glass_whose_shadow_is_off_casts_all_the_same(scene):
    """The usual way to let EEVEE's light through glass; Attach turns the shadow on while maps are shown."""
    label = material("Label", **{"Transmission Weight": 0.0})
    for name, *materials in (("Ball", material("Clear"), label), ("Stone", label)):
        ball(name, *materials).visible_shadow = False
    made = bpy.data.objects["Ball"].data
    made.polygons.foreach_set("material_index", [k % 2 for k in range(len(made.polygons))])
    made.update()
    found, warnings = read()
    assert [c.name for c in found.casters] == ["Ball"] and len(found.casters[0].triangles) == 16 * 14 / 2
    assert found.occluders == () and [w for w in warnings if "closed" not in w] == []
    assert caster_names(bpy.context.evaluated_depsgraph_get(), {"Floor"}) == ["Ball"]


def test_plain_things_block(scene):
    ball("Ball", material("Clear"))
    ball("Stone", material("Grey", **{"Transmission Weight": 0.0}))
    ball("Bare")
    found, _ = read()
    assert [c.name for c in found.casters] == ["Ball"]
    assert sorted(o.name for o in found.occluders) == ["Bare", "Stone"]


TRANSFORMS = {
    "plain": Matrix.Identity(4),
    "stretched": Matrix.LocRotScale(Vector((3, -2, 1)), Euler((0.4, -0.7, 1.1)), Vector((2.0, 0.5, 0.25))),
    "mirrored": Matrix.LocRotScale(Vector((0, 0, 7)), Euler((0.2, 0.1, 0.3)), Vector((-1.5, 1.0, 0.8))),
}


@pytest.mark.parametrize("name", TRANSFORMS)
@pytest.mark.parametrize("smooth", [True, False])
def test_normals_point_out_under_any_transform(scene, name, smooth):
    made = ball("Ball", material("Clear"), smooth=smooth)
    made.matrix_world = TRANSFORMS[name]
    (caster,) = read()[0].casters
    m = np.array(TRANSFORMS[name])
    inverse = np.linalg.inv(m[:3, :3])
    on_ball = (caster.positions - m[:3, 3]) @ inverse.T
    np.testing.assert_allclose(np.linalg.norm(on_ball, axis=1), 0.3, atol=1e-5)
    corners = caster.positions[caster.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    shaded = caster.normals[caster.normal_triangles]
    assert (np.einsum("tk,tck->tc", across, shaded) > 0).all()
    assert (np.einsum("tk,tk->t", across, corners.mean(1) - m[:3, 3]) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(caster.normals, axis=1), 1, atol=1e-12)
    assert (caster.normal_triangles is caster.triangles) == smooth
    if smooth:
        normals = on_ball @ inverse
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        # Blender weighs the faces at a vertex by their angles; coarse as the ball is, that is a degree or two off.
        assert np.einsum("vk,vk->v", caster.normals, normals).min() > math.cos(math.radians(3))


def test_triangles_go_by_their_own_material(scene):
    made = ball("Bottle", material("Clear"), material("Label", **{"Transmission Weight": 0.0}))
    half = len(made.data.polygons) // 2
    made.data.polygons.foreach_set("material_index", [0] * half + [7] * (len(made.data.polygons) - half))
    found, _ = read()
    (caster,), (occluder,) = found.casters, found.occluders
    whole = {tuple(t) for t in np.concatenate([caster.triangles, occluder.triangles])}
    assert len(caster.triangles) + len(occluder.triangles) == len(whole) == 16 * 14
    assert caster.positions[caster.triangles, 2].max() <= occluder.positions[occluder.triangles, 2].max()


def test_slots_that_are_the_objects_own(scene):
    one = ball("One", material("Clear"))
    other = bpy.data.objects.new("Other", one.data)
    scene.collection.objects.link(other)
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = material("Steel", Metallic=1.0, **{"Transmission Weight": 0.0})
    kinds = {caster.name: type(caster.material) for caster in read()[0].casters}
    assert kinds == {"One": Glass, "Other": Mirror}


def test_objects_of_one_material_are_one_medium_and_each_instance_casts(scene):
    clear = material("Clear")
    pearl = ball("Pearl", clear)
    ball("Big", clear)
    grid = add_grid("Holder", 3.0, n=3)
    grid.instance_type = "VERTS"
    grid.show_instancer_for_render = False
    pearl.parent = grid
    casters = read()[0].casters
    assert sorted(c.name for c in casters) == ["Big"] + 16 * ["Pearl"]
    assert len({id(c.material) for c in casters}) == 1
    assert len({tuple(c.positions.mean(0).round(3)) for c in casters}) == 17


def test_rough_glass_blocks_and_says_so_until_it_is_asked_to_cast(scene):
    ball("Ball", material("Clear"))
    frosted = ball("Lamp", material("Frosted", Roughness=0.3))
    found, warnings = read()
    assert [o.name for o in found.occluders] == ["Lamp"]
    assert warnings == [
        "'Frosted' of object 'Lamp' is glass of roughness 0.3 and casts no caustics; set 0.1 or less, "
        "or its Caustics to Casts to take it as smooth."
    ]
    frosted.dapple.caustics = "ALWAYS"
    found, warnings = read()
    assert [c.name for c in found.casters] == ["Ball", "Lamp"]
    assert warnings == ["Caustics take material 'Frosted' as smooth, of roughness 0.3."]


def test_the_roughness_that_is_said_to_cast_does(scene):
    """0.1 as it is typed, which Blender keeps as a little more."""
    ball("Ball", material("Clear", Roughness=0.1))
    assert [c.name for c in read()[0].casters] == ["Ball"]
    bpy.data.materials["Clear"].node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.101
    with pytest.raises(DappleError, match=r"glass of roughness 0\.1 and"):
        read()


def test_what_casts_in_cycles_casts(scene):
    frosted = ball("Lamp", material("Frosted", Roughness=0.3))
    frosted.cycles.is_caustics_caster = True
    assert [c.name for c in read()[0].casters] == ["Lamp"]
    frosted.dapple.caustics = "NEVER"
    ball("Ball", material("Clear"))
    found, warnings = read()
    assert [o.name for o in found.occluders] == ["Lamp"]
    assert warnings == []


def test_to_cast_without_a_material_that_does(scene):
    ball("Ball", material("Clear"))
    ball("Stone").dapple.caustics = "ALWAYS"
    found, (warning,) = read()
    assert [o.name for o in found.occluders] == ["Stone"]
    assert "'Stone' is to cast caustics, but no material of it refracts or mirrors" in warning


def test_a_tube_without_ends_is_open_and_one_with_split_edges_is_closed(scene):
    for name, fill in (("Pipe", "NOTHING"), ("Rod", "NGON")):
        bpy.ops.mesh.primitive_cylinder_add(vertices=12, end_fill_type=fill, location=(0, 0, 2))
        bpy.context.object.name = name
        bpy.context.object.data.materials.append(material(name))
    split = bpy.data.objects["Rod"].modifiers.new("Split", "EDGE_SPLIT")
    split.split_angle = 0.5
    assert [w[:24] for w in read()[1]] == ["Glass 'Pipe' is not clos"]


def test_glass_that_is_open_or_inside_out_is_said(scene):
    ball("Good", material("Clear"))
    pane = add_grid("Pane", 3.0)
    pane.data.materials.append(material("Window"))
    made = ball("Turned", material("Turned"))
    made.data.flip_normals()
    _, warnings = read()
    assert len(warnings) == 2
    assert any("Glass 'Pane' is not closed" in warning for warning in warnings)
    assert any("Glass 'Turned' is inside out" in warning for warning in warnings)


def test_rough_things_alone_are_no_scene_and_why_is_said(scene):
    ball("Lamp", material("Frosted", Roughness=0.3))
    with pytest.raises(DappleError, match=r"Nothing bends light or mirrors it: pick the water.*'Frosted' .* roughness"):
        read()


def test_sun_from_below_lights_glass_where_no_water_is(scene):
    ball("Ball", material("Clear"))
    bpy.data.objects["Sun"].rotation_euler.x = math.pi
    (light,) = read()[0].lights
    assert light.direction[2] == pytest.approx(1)


def test_animated_material_is_that_of_the_frame(scene):
    clear = material("Clear")
    ball("Ball", clear)
    shader = next(n for n in clear.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    for frame, ior in ((1, 1.3), (2, 1.6)):
        shader.inputs["IOR"].default_value = ior
        shader.inputs["IOR"].keyframe_insert("default_value", frame=frame)
    for frame, ior in ((1, 1.3), (2, 1.6)):
        scene.frame_set(frame)
        assert read()[0].casters[0].material.eta == pytest.approx(ior)


def test_names_of_casters(scene):
    ball("Ball", material("Clear"))
    ball("Lamp", material("Frosted", Roughness=0.3))
    ball("Sea", bpy.data.materials["Clear"])
    assert caster_names(bpy.context.evaluated_depsgraph_get(), {"Sea", "Floor"}) == ["Ball"]
