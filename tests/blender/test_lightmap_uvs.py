"""UV maps for receivers that have none: without overlaps, beside the artist's own, and told."""

import bpy
import numpy as np
import pytest

from dapple.kernels.maps.texels import overlap, rasterise
from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.operators.read.extract import read_scene
from dapple.operators.read.lightmap_uvs import make, supply
from dapple.operators.read.mesh_arrays import LAYER, TopologyCache
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import add_grid, build_pool
from dapple.tests.waves import transmitted


@pytest.fixture
def pool(empty_scene, tmp_path):
    build_pool(empty_scene, tmp_path)
    empty_scene.dapple.resolution = 128
    return empty_scene


def bare(scene, build, **words):
    """A mesh without a UV map, in place of the floor."""
    bpy.data.objects.remove(bpy.data.objects["Floor"])
    build(**words)
    obj = bpy.context.object
    obj.name = "Floor"
    while obj.data.uv_layers:
        obj.data.uv_layers.remove(obj.data.uv_layers[0])
    obj.data.update()
    scene.collection.objects.unlink(obj)
    scene.dapple.receivers.objects.link(obj)
    return obj


def receiver():
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return read_scene(depsgraph, ("Water",), ("Floor",), TopologyCache())[0].receivers[0]


SHAPES = {
    "cube": (bpy.ops.mesh.primitive_cube_add, {}),
    "sphere": (bpy.ops.mesh.primitive_uv_sphere_add, {}),
    "torus": (bpy.ops.mesh.primitive_torus_add, {}),
    "Suzanne": (bpy.ops.mesh.primitive_monkey_add, {}),
    "grid": (bpy.ops.mesh.primitive_grid_add, {"x_subdivisions": 30, "y_subdivisions": 30}),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_uvs_do_not_overlap_and_keep_a_gap(pool, shape):
    build, words = SHAPES[shape]
    obj = bare(pool, build, **words)
    settings = request_from_scene(pool).settings
    assert "'Floor'" in supply(bpy.context, request_from_scene(pool))
    own = receiver()
    assert overlap(own.uvs, 1024) <= 1e-4
    texels = rasterise(own, settings.resolution, settings.padding)
    assert len(texels.texel) > 0.05 * settings.resolution**2
    # Texels of other charts lie further off than those that bilinear look-ups at a border read.
    chart = np.full(settings.resolution**2, -1)
    chart[texels.texel] = texels.chart[texels.triangle]
    image = chart.reshape(settings.resolution, -1)
    assert ((image[:, 1:] == image[:, :-1]) | (image[:, 1:] < 0) | (image[:, :-1] < 0)).all()
    # Alike all over: the world's area per texel.
    density = texels.area / np.median(texels.area)
    assert np.quantile(density, 0.9) < 4 * np.quantile(density, 0.1)
    assert supply(bpy.context, request_from_scene(pool)) == ""
    assert [layer.name for layer in obj.data.uv_layers] == [LAYER]


def test_scale_counts(pool):
    """A cube stretched to ten times its width has texels of one size on all sides."""
    obj = bare(pool, bpy.ops.mesh.primitive_cube_add)
    obj.scale = 10.0, 1.0, -1.0
    bpy.context.view_layer.update()
    make(bpy.context, [obj], request_from_scene(pool).settings)
    texels = rasterise(receiver(), 128, 0)
    assert np.quantile(texels.area, 0.75) < 1.05 * np.quantile(texels.area, 0.25)


def test_what_the_artist_has_stays(pool):
    floor = bpy.data.objects["Floor"]
    mesh = floor.data
    mesh.uv_layers.new(name="Tiles")
    mesh.uv_layers["UVMap"].active_render, mesh.uv_layers.active_index = True, 1
    mesh.polygons[0].hide = True
    kept = [[tuple(uv.vector) for uv in layer.uv] for layer in mesh.uv_layers]
    water = bpy.data.objects["Water"]
    bpy.context.view_layer.objects.active = water
    floor.select_set(False)
    selected, counts = bpy.context.selected_objects, (len(bpy.data.scenes), len(bpy.data.objects), len(bpy.data.meshes))
    assert supply(bpy.context, request_from_scene(pool)) == ""
    make(bpy.context, [floor], request_from_scene(pool).settings)
    assert [layer.name for layer in mesh.uv_layers] == ["UVMap", "Tiles", LAYER]
    assert [[tuple(uv.vector) for uv in layer.uv] for layer in mesh.uv_layers][:2] == kept
    assert mesh.uv_layers["UVMap"].active_render and mesh.uv_layers.active_index == 1
    assert bpy.context.selected_objects == selected and bpy.context.view_layer.objects.active == water
    assert (len(bpy.data.scenes), len(bpy.data.objects), len(bpy.data.meshes)) == counts
    assert mesh.polygons[0].hide and bpy.context.mode == "OBJECT"


def test_button_makes_them_and_bake_uses_them(pool, tmp_path):
    bare(pool, bpy.ops.mesh.primitive_grid_add, size=2.0)
    with pytest.raises(DappleError, match=r"'Floor' has no UV map; unwrap it, or press Make Lightmap UVs"):
        list(bake(bpy.context, request_from_scene(pool, frames=(1,))))
    assert bpy.ops.dapple.lightmap_uvs() == {"FINISHED"}
    (step,) = bake(bpy.context, request_from_scene(pool, frames=(1,)))
    image = read_exr(step.maps[0]).astype(float)
    assert image[64, 64] == pytest.approx(transmitted(1.0), rel=2e-3)


def test_bake_button_makes_them_and_says_so(pool):
    obj = bare(pool, bpy.ops.mesh.primitive_grid_add, size=2.0)
    pool.frame_end = 1
    assert bpy.ops.dapple.bake_animation() == {"FINISHED"}
    assert LAYER in obj.data.uv_layers


def test_shared_mesh_is_unwrapped_once(pool):
    floor = bare(pool, bpy.ops.mesh.primitive_cube_add)
    twin = bpy.data.objects.new("Twin", floor.data)
    pool.dapple.receivers.objects.link(twin)
    supply(bpy.context, request_from_scene(pool))
    assert [layer.name for layer in floor.data.uv_layers] == [LAYER]


def no_base_faces(obj):
    tree = bpy.data.node_groups.new("Made", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, leave = tree.nodes.new("GeometryNodeMeshCube"), tree.nodes.new("NodeGroupOutput")
    tree.links.new(cube.outputs[0], leave.inputs[0])
    obj.data.clear_geometry()
    obj.modifiers.new("Made", "NODES").node_group = tree


def eight_layers(obj):
    for _ in range(8):
        obj.data.uv_layers.new()
    obj.data.update()


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [(no_base_faces, "modifiers make its faces; let them store a UV map 'Dapple'"), (eight_layers, "eight UV maps")],
)
def test_meshes_that_take_none_are_told(pool, spoil, sentence):
    obj = bare(pool, bpy.ops.mesh.primitive_cube_add)
    spoil(obj)
    with pytest.raises(DappleError, match=f"'Floor' cannot be given a UV map: .*{sentence}"):
        make(bpy.context, [obj], request_from_scene(pool).settings)


@pytest.mark.parametrize("kind", ["FLOAT2", "FLOAT_VECTOR"])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_vectors_that_nodes_store_are_uvs(pool, kind, domain):
    mesh = bpy.data.objects["Floor"].data
    expected = receiver().uvs
    uvs = {"CORNER": np.array([uv.vector for uv in mesh.uv_layers[0].uv])}
    vertex = np.array([loop.vertex_index for loop in mesh.loops])
    uvs["POINT"] = np.zeros((len(mesh.vertices), 2))
    uvs["POINT"][vertex] = uvs["CORNER"]
    mesh.uv_layers.remove(mesh.uv_layers[0])
    stored = mesh.attributes.new("UVMap", kind, domain)
    values = np.zeros((len(stored.data), 2 if kind == "FLOAT2" else 3), np.float32)
    values[:, :2] = uvs[domain]
    stored.data.foreach_set("vector", values.ravel())
    mesh.update()
    np.testing.assert_allclose(receiver().uvs, expected, atol=1e-6)


def test_copies_by_a_modifier_overlap_and_are_told_by_name(pool):
    obj = bare(pool, bpy.ops.mesh.primitive_grid_add, size=2.0)
    obj.modifiers.new("Twice", "ARRAY").count = 2
    supply(bpy.context, request_from_scene(pool))
    with pytest.raises(
        DappleError, match=r"'Floor' cannot take a lightmap: 9.*% of its UV map overlaps.*apply modifiers that copy"
    ):
        list(bake(bpy.context, request_from_scene(pool, frames=(1,))))


def test_a_grid_beside_it_is_left_alone(pool):
    bare(pool, bpy.ops.mesh.primitive_cube_add)
    other = add_grid("Other", -1.0, pool.dapple.receivers)
    supply(bpy.context, request_from_scene(pool))
    assert [layer.name for layer in other.data.uv_layers] == ["UVMap"]


def test_faces_without_area_in_the_uv_map_are_told_by_name(pool):
    """A quarter of the floor lies on one point of the map: the rest is baked, and the bake says what is lost."""
    mesh = bpy.data.objects["Floor"].data
    for face in mesh.polygons:
        if face.center.x < 0 and face.center.y < 0:
            for corner in face.loop_indices:
                mesh.uv_layers[0].uv[corner].vector = 0.1, 0.1
    mesh.update()
    (step,) = bake(bpy.context, request_from_scene(pool, frames=(1,)))
    assert [said for said in step.warnings if "'Floor'" in said] == [
        "25.0% of the area of receiver 'Floor' has no area in its UV map: light there is lost. Unwrap it, or press "
        "Make Lightmap UVs."
    ]
