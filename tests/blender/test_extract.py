"""What Blender shows and what the kernels get: positions, normals, UVs, lamps against closed forms."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from dapple.operators.errors import DappleError
from dapple.operators.read.extract import read_scene
from dapple.operators.read.mesh_arrays import TopologyCache


def add(mesh_name, data):
    thing = bpy.data.objects.new(mesh_name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def grid(name, n=6, size=2.0, z=0.0, smooth=True):
    """n x n quads over size x size metres, with a UV layer that covers the unit square."""
    x, y = np.meshgrid(*[np.linspace(-size / 2, size / 2, n + 1)] * 2)
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    faces = np.stack([i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3).tolist(), [], faces.tolist())
    layer = mesh.uv_layers.new(name="UVMap")
    for loop, uv in zip(mesh.loops, layer.data):
        co = mesh.vertices[loop.vertex_index].co
        uv.uv = (co.x / size + 0.5, co.y / size + 0.5)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    thing = add(name, mesh)
    thing.location.z = z
    return thing


def sphere(name, smooth=True):
    """A unit sphere."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16)
    thing = bpy.context.object
    thing.name = name
    thing.data.polygons.foreach_set("use_smooth", [smooth] * len(thing.data.polygons))
    thing.data.update()
    return thing


def sun(energy=1.0, rotation=(0.0, 0.0, 0.0)):
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy = energy
    lamp = add("Sun", light)
    lamp.rotation_euler = rotation
    return lamp


@pytest.fixture
def pool(empty_scene):
    """A floor and a sun; each test brings its own water."""
    grid("Floor", z=-5.0)
    sun()
    return empty_scene


def read(water=("Water",), receivers=("Floor",), topology=None):
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return read_scene(depsgraph, water, receivers, topology or TopologyCache())


def geometric_normals(mesh):
    v = mesh.positions[mesh.triangles]
    return np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])


TRANSFORMS = {
    "plain": Matrix.Identity(4),
    "stretched": Matrix.LocRotScale(Vector((3, -2, 1)), Euler((0.4, -0.7, 1.1)), Vector((2.0, 0.5, 0.25))),
    "mirrored": Matrix.LocRotScale(Vector((0, 0, 7)), Euler((0.2, 0.1, 0.3)), Vector((-1.5, 1.0, 0.8))),
    "turned inside out": Matrix.Scale(-1.0, 4),
}


@pytest.mark.parametrize("name", TRANSFORMS)
@pytest.mark.parametrize("parented", [False, True])
def test_ellipsoid_under_any_transform(pool, name, parented):
    transform = TRANSFORMS[name]
    water = sphere("Water")
    if parented:
        parent = add("Parent", None)
        parent.matrix_world = transform
        water.parent = parent
    else:
        water.matrix_world = transform
    mesh = read()[0].water
    m = np.array(transform)
    on_sphere = (mesh.positions - m[:3, 3]) @ np.linalg.inv(m[:3, :3]).T
    np.testing.assert_allclose(np.linalg.norm(on_sphere, axis=1), 1.0, atol=1e-5)
    normals = on_sphere @ np.linalg.inv(m[:3, :3])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert mesh.normal_triangles is mesh.triangles
    np.testing.assert_allclose((mesh.normals * normals).sum(1), 1.0, atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-12)
    outwards = (geometric_normals(mesh) * mesh.normals[mesh.normal_triangles].sum(1)).sum(1)
    assert (outwards > 0).all()
    assert (mesh.twins >= 0).all()


def test_flat_shading_has_one_normal_a_face(pool):
    sphere("Water", smooth=False)
    mesh = read()[0].water
    assert len(mesh.normals) == len(bpy.data.objects["Water"].data.polygons)
    shaded = mesh.normals[mesh.normal_triangles]
    np.testing.assert_array_equal(shaded[:, 0], shaded[:, 2])
    flat = geometric_normals(mesh)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    np.testing.assert_allclose((flat * shaded[:, 0]).sum(1), 1.0, atol=1e-5)


def test_sharp_edges_split_normals_at_corners(pool):
    water = grid("Water", n=2)
    water.data.vertices[4].co.z = 0.5
    for edge in water.data.edges:
        edge.use_edge_sharp = 4 in edge.vertices
    mesh = read()[0].water
    assert len(mesh.normals) == len(water.data.loops)
    at_peak = mesh.normals[mesh.normal_triangles[mesh.triangles == 4]]
    assert len(np.unique(at_peak.round(4), axis=0)) == 4


def test_scaled_flat_still_points_up(pool):
    grid("Water").scale.z = 0.0
    mesh = read()[0].water
    np.testing.assert_allclose(mesh.normals, np.tile([0, 0, 1.0], (len(mesh.normals), 1)), atol=1e-6)


def test_modifiers_and_frames(pool):
    water = grid("Water", n=3, size=6.0)
    water.modifiers.new("Finer", "SUBSURF").subdivision_type = "SIMPLE"
    water.modifiers["Finer"].levels = 2
    water.shape_key_add(name="Basis")
    raised = water.shape_key_add(name="Raised")
    for point in raised.data:
        point.co.z = 0.25 * point.co.x
    for frame, value in ((1, 0.0), (11, 1.0)):
        raised.value = value
        raised.keyframe_insert("value", frame=frame)
    topology = TopologyCache()
    pool.frame_set(1)
    flat = read(topology=topology)[0].water
    pool.frame_set(11)
    tilted = read(topology=topology)[0].water
    assert len(flat.positions) == 13 * 13
    np.testing.assert_allclose(flat.positions[:, 2], 0.0, atol=1e-6)
    np.testing.assert_allclose(tilted.positions[:, 2], 0.25 * tilted.positions[:, 0], atol=1e-6)
    expected = np.array([-0.25, 0, 1]) / math.sqrt(1 + 0.25**2)
    np.testing.assert_allclose(tilted.normals, np.tile(expected, (169, 1)), atol=1e-4)
    assert tilted.twins is flat.twins
    water.modifiers["Finer"].levels = 1
    coarser = read(topology=topology)[0].water
    assert len(coarser.twins) == 3 * len(coarser.triangles) != len(flat.twins)


def test_two_waters_join(pool):
    grid("Water", n=2)
    grid("Pond", n=3, z=1.0, smooth=False)
    alone = read()[0].water
    both = read(water=("Water", "Pond"))[0].water
    assert both.name == "Water + Pond"
    assert len(both.positions) == 9 + 16
    count = len(alone.triangles)
    np.testing.assert_array_equal(both.triangles[:count], alone.triangles)
    assert both.triangles[count:].min() == 9
    np.testing.assert_array_equal(both.twins[: 3 * count], alone.twins)
    assert len(both.normals) == 9 + 9
    np.testing.assert_allclose(both.normals[both.normal_triangles][..., 2], 1.0, atol=1e-6)


def test_receiver_has_the_layer_that_renders(pool):
    grid("Water", z=1.0)
    floor = bpy.data.objects["Floor"]
    second = floor.data.uv_layers.new(name="Lightmap")
    for uv in second.data:
        uv.uv = (uv.uv.y / 2, uv.uv.x / 2)
    second.active_render = True
    receiver = read()[0].receivers[0]
    corners = receiver.positions[receiver.triangles][..., :2]
    np.testing.assert_allclose(receiver.uvs, (corners[..., ::-1] / 2 + 0.5) / 2, atol=1e-6)


def test_mirrored_receiver_keeps_uvs_with_their_corners(pool):
    grid("Water", z=1.0)
    bpy.data.objects["Floor"].scale.x = -1.0
    receiver = read()[0].receivers[0]
    corners = receiver.positions[receiver.triangles][..., :2] * (-1, 1)
    np.testing.assert_allclose(receiver.uvs, corners / 2 + 0.5, atol=1e-6)
    assert (geometric_normals(receiver)[:, 2] > 0).all()


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


def test_sun_direction_and_strength(pool):
    grid("Water", z=1.0)
    lamp = bpy.data.objects["Sun"]
    lamp.rotation_euler = Vector((-0.25, -0.1, 1.0)).to_track_quat("Z", "Y").to_euler()
    lamp.scale = (3, 3, 3)
    lamp.data.energy, lamp.data.color, lamp.data.angle = 3.0, (1.0, 0.5, 0.25), math.radians(0.53)
    (found,) = read()[0].lights
    np.testing.assert_allclose(found.direction, np.array([0.25, 0.1, -1]) / math.sqrt(1.0725), atol=1e-6)
    np.testing.assert_allclose(found.irradiance, (3.0, 1.5, 0.75))
    assert found.angle == pytest.approx(math.radians(0.53))


@pytest.mark.skipif("exposure" not in bpy.types.SunLight.bl_rna.properties, reason="lamps have it since Blender 4.5")
def test_exposure_temperature_and_radiance(pool):
    grid("Water", z=1.0)
    light = bpy.data.lights["Sun"]
    light.exposure, light.use_temperature, light.temperature = 1.0, True, 4000.0
    light.normalize, light.angle = False, 0.5
    (found,) = read()[0].lights
    # Cycles 5.0 renders a white floor under this lamp, white, at 0.19225 W/m^2
    np.testing.assert_allclose(found.irradiance, 2 * 0.192248 * np.array(light.temperature_color), rtol=1e-3)


def test_lamps_that_are_left_out_are_named(pool):
    grid("Water", z=1.0)
    add("Panel", bpy.data.lights.new("Panel", "AREA")).scale.y = 0.0
    add("Sunken", bpy.data.lights.new("Sunken", "POINT")).location.z = 0.5
    upward = sun(rotation=(math.pi, 0, 0))
    unlit = sun(energy=0.0)
    scene, warnings = read()
    assert [s.name for s in scene.lights] == ["Sun"]
    assert any("'Panel' has no area and was left out: set its size" in w for w in warnings)
    assert any("'Sunken' is under the water" in w for w in warnings)
    assert any(f"'{upward.name}' shines upward" in w for w in warnings)
    assert not any(unlit.name in w for w in warnings)


def test_instanced_water_is_water_too(pool):
    grid("Water", z=1.0)
    ponds = bpy.data.collections.new("Ponds")
    ponds.objects.link(bpy.data.objects["Water"])
    instance = add("Far pond", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", ponds
    instance.location.x = 5.0
    scene, warnings = read()
    assert scene.occluders == () and warnings == []
    assert sorted(scene.water.positions[:, 0].round(6))[::97] == [-1.0, 6.0]


def test_hidden_water_is_an_error(pool):
    grid("Water", z=1.0).hide_viewport = True
    with pytest.raises(DappleError, match=r"'Water' is not in the scene as the viewport shows it; unhide"):
        read()
