"""What Blender shows and what the kernels get: positions, normals, UVs against closed forms."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from dapple.operators.errors import DappleError
from dapple.operators.read.mesh_arrays import TopologyCache
from dapple.tests.blender.read_things import add, floor_and_sun, grid, read, sphere


@pytest.fixture
def pool(empty_scene):
    return floor_and_sun(empty_scene)


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
