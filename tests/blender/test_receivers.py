"""What takes light, and in which map: objects that share one, instances, a thousand of them."""

import json

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.operators.read.density import side_in_metres
from dapple.operators.read.extract import read_scene
from dapple.operators.read.mesh_arrays import TopologyCache
from dapple.operators.show.attach import attach
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import add_grid, build_pool, files_in
from dapple.tests.waves import transmitted


def run(scene, **words):
    return list(bake(bpy.context, request_from_scene(scene, **words)))


def squeeze(obj, low, high):
    """Move the UVs of a grid from the unit square into the strip low to high of u."""
    layer = obj.data.uv_layers.active.uv
    for corner in layer:
        corner.vector.x = low + (high - low) * corner.vector.x


@pytest.fixture
def pool(empty_scene, tmp_path):
    build_pool(empty_scene, tmp_path)
    empty_scene.dapple.resolution = 32
    return empty_scene


def halves(scene):
    """The floor cut in two objects of half its width, each in its half of one map."""
    floor = bpy.data.objects["Floor"]
    floor.scale.x, floor.location.x = 0.5, -0.5
    other = add_grid("Other", 0.0, scene.dapple.receivers)
    other.scale.x, other.location.x = 0.5, 0.5
    squeeze(floor, 0.0, 0.5)
    squeeze(other, 0.5, 1.0)
    floor.dapple.shared_map = other.dapple.shared_map = "Ground"


def test_two_objects_share_one_map_as_if_they_were_one(pool, tmp_path):
    (whole,) = run(pool, frames=(1,), out=tmp_path / "one")
    halves(pool)
    (last,) = run(pool, frames=(1,), out=tmp_path / "two")
    assert last.maps == (tmp_path / "two/Ground/caustics_0001.exr",)
    np.testing.assert_allclose(read_exr(last.maps[0]), read_exr(whole.maps[0]), rtol=1e-4)
    attach(bpy.context, ("Floor", "Other"), tmp_path / "two")
    shown = [image for image in bpy.data.images if "dapple_map" in image]
    assert len(shown) == 1


def test_an_object_can_name_the_map_of_another(pool, tmp_path):
    halves(pool)
    bpy.data.objects["Floor"].dapple.shared_map = ""
    bpy.data.objects["Other"].dapple.shared_map = "Floor"
    (last,) = run(pool, frames=(1,), out=tmp_path / "two")
    assert [path.parent.name for path in last.maps] == ["Floor"]


def test_uvs_that_overlap_in_a_shared_map_are_told(pool):
    halves(pool)
    squeeze(bpy.data.objects["Other"], -0.2, 0.8)
    with pytest.raises(DappleError, match=r"'Ground' cannot take a lightmap.*overlap"):
        run(pool, frames=(1,))


def assert_still(image):
    """The light of a sun overhead that still water lets pass, on all but corners, where two borders meet."""
    assert image.mean() == pytest.approx(transmitted(1.0), rel=2e-3)
    assert (abs(image - transmitted(1.0)) > 5e-3).mean() < 0.02


def instanced(scene, places):
    """An Empty among the receivers for each place that shows a collection with one grid of 0.8 m."""
    stones = bpy.data.collections.new("Stones")
    stone = add_grid("Stone", 0.0, stones, n=1)
    stone.scale = 0.4, 0.4, 1.0
    for k, place in enumerate(places):
        empty = bpy.data.objects.new(f"Place {k}", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", stones, place
        scene.dapple.receivers.objects.link(empty)


def test_instances_take_light_each_in_a_map_of_its_own(pool, tmp_path):
    instanced(pool, [(-0.5, 0.0, 0.3), (0.5, 0.2, 0.5)])
    bpy.data.objects["Place 1"].scale.x = -1
    (last,) = run(pool, frames=(1,), out=tmp_path / "out")
    assert sorted(path.parent.name for path in last.maps) == ["Floor", "Place 0 Stone 0", "Place 1 Stone 0"]
    for path in last.maps[1:]:
        assert_still(read_exr(path))
    notes = attach(bpy.context, ("Floor", "Place 0", "Place 1"), tmp_path / "out")
    assert any("'Place 0' have maps" in note for note in notes)


def scattered(floor, count, keep=False):
    """Instances of a quad with UVs on a geometry-nodes lattice in an object, in place of its mesh or beside it."""
    stone = add_grid("Stone", -50.0, n=1)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, links = tree.nodes, tree.links
    lattice, on_points = nodes.new("GeometryNodeMeshGrid"), nodes.new("GeometryNodeInstanceOnPoints")
    model, out = nodes.new("GeometryNodeObjectInfo"), nodes.new("NodeGroupOutput")
    side = int(count**0.5)
    lattice.inputs["Vertices X"].default_value, lattice.inputs["Vertices Y"].default_value = side, count // side
    lattice.inputs["Size X"].default_value = lattice.inputs["Size Y"].default_value = 1.8
    model.inputs["Object"].default_value = stone
    model.inputs["As Instance"].default_value = True
    on_points.inputs["Scale"].default_value = (0.02, 0.02, 0.02)
    links.new(lattice.outputs["Mesh"], on_points.inputs["Points"])
    links.new(model.outputs["Geometry"], on_points.inputs["Instance"])
    both = nodes.new("GeometryNodeJoinGeometry")
    links.new(on_points.outputs["Instances"], both.inputs[0])
    if keep:
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        links.new(nodes.new("NodeGroupInput").outputs[0], both.inputs[0])
    links.new(both.outputs[0], out.inputs[0])
    floor.modifiers.new("Scatter", "NODES").node_group = tree


def test_a_thousand_instances(pool, tmp_path):
    """1000 quads that geometry nodes scatter under still water: as many maps, all of Fresnel's light."""
    floor = bpy.data.objects["Floor"]
    pool.dapple.resolution = 16
    scattered(floor, 1000)
    floor.dapple.instances_receive = True
    scene, _ = read_scene(bpy.context.evaluated_depsgraph_get(), ("Water",), ("Floor",), TopologyCache())
    names = [receiver.name for receiver in scene.receivers]
    assert len(set(names)) == len(names) == 31 * 32
    (last,) = run(pool, frames=(1,), out=tmp_path / "out")
    assert len(last.maps) == len(names)
    assert len(files_in(tmp_path / "out")) == len(names) + 1
    rng = np.random.default_rng(0)
    for k in rng.integers(0, len(names), 20):
        assert_still(read_exr(last.maps[k]))


def test_instances_that_do_not_receive_shade(pool):
    scattered(bpy.data.objects["Floor"], 16, keep=True)
    scene, _ = read_scene(bpy.context.evaluated_depsgraph_get(), ("Water",), ("Floor",), TopologyCache())
    assert [receiver.name for receiver in scene.receivers] == ["Floor"]
    assert len(scene.occluders) >= 16


def test_maps_that_fit_no_memory_are_told(pool):
    instanced(pool, [(-0.5, 0.0, 0.3), (0.5, 0.2, 0.5)])
    pool.dapple.resolution = 16384
    with pytest.raises(DappleError, match=r"3 maps of 16384 texels do not fit into memory; set 9459 at most"):
        run(pool, frames=(1,))


def test_udim_tiles_have_a_map_each(pool, tmp_path):
    """The halves of the floor in two tiles, one above the other, take what they take in one map."""
    run(pool, frames=(1,), out=tmp_path / "one")
    floor = bpy.data.objects["Floor"]
    for face in floor.data.polygons:
        up = face.center.x > 0
        for corner in face.loop_indices:
            uv = floor.data.uv_layers[0].uv[corner].vector
            uv.x, uv.y = 2 * uv.x - up, uv.y + up
    floor.data.update()
    (last,) = run(pool, frames=(1,), out=tmp_path / "two")
    assert [path.name for path in last.maps] == ["caustics_1001.0001.exr", "caustics_1011.0001.exr"]
    for path in last.maps:
        assert_still(read_exr(path).astype(float))
    books = [json.loads((tmp_path / out / "bake.json").read_text())["frames"]["1"] for out in ("one", "two")]
    flux = [np.sum(list(entry["flux_received"].values()), axis=0) for entry in books]
    np.testing.assert_allclose(flux[1], flux[0], rtol=2e-4)
    attach(bpy.context, ("Floor",), tmp_path / "two")
    assert sorted(i["dapple_map"] for i in bpy.data.images if "dapple_map" in i) == ["Floor [1001]", "Floor [1011]"]


def test_faces_between_tiles_are_told(pool):
    for uv in bpy.data.objects["Floor"].data.uv_layers[0].uv:
        uv.vector.x += 0.3
    with pytest.raises(DappleError, match=r"'Floor' cannot take a lightmap: .*leaves the unit square"):
        run(pool, frames=(1,))


def test_each_receiver_has_the_texels_per_metre_that_are_set(pool, tmp_path):
    """A floor of 2 m, and a step of 0.5 m that is twice as large in the second frame."""
    step = add_grid("Step", 0.3, pool.dapple.receivers)
    for frame, scale in ((1, 0.25), (2, 0.5)):
        step.scale = scale, scale, 1.0
        step.keyframe_insert("scale", frame=frame)
    pool.dapple.texels_per_metre, pool.frame_end = 60.0, 2
    steps = run(pool, out=tmp_path / "out")
    shapes = {path.parent.name + path.stem[-1]: read_exr(path).shape[0] for step in steps for path in step.maps}
    assert shapes == {"Floor1": 128, "Floor2": 128, "Step1": 32, "Step2": 32}
    assert json.loads((tmp_path / "out/bake.json").read_text())["texels_per_metre"] == 60.0
    (again,) = run(pool, frames=(2,), out=tmp_path / "out")
    assert "left as it is" in again.message, "what is baked is the same in parts"
    pool.dapple.texels_per_metre = 0.0
    pool.dapple.resolution = 128
    run(pool, frames=(2,), out=tmp_path / "alike")
    floors = [read_exr(tmp_path / out / "Floor/caustics_0002.exr").astype(float) for out in ("out", "alike")]
    assert ((floors[0] - floors[1]) ** 2).mean() < 1e-4 * (floors[1] ** 2).mean()
    books = [json.loads((tmp_path / out / "bake.json").read_text())["frames"]["2"] for out in ("out", "alike")]
    for name in ("Floor", "Step"):
        np.testing.assert_allclose(*(book["flux_received"][name] for book in books), rtol=5e-3)


def test_maps_per_metre_that_fit_no_memory_are_told(pool):
    instanced(pool, [(-0.5, 0.0, 0.3)])
    bpy.data.objects["Floor"].scale = 10.0, 10.0, 1.0
    pool.dapple.texels_per_metre = 1000.0
    with pytest.raises(DappleError, match=r"2 maps of 16384 texels and less do not fit .* 99 % of the texels"):
        run(pool, frames=(1,))


@pytest.mark.parametrize(("scale", "density", "side"), [(1.0, 8.0, 16), (1.0, 100.0, 208), (4.0, 100.0, 800)])
def test_texels_per_metre_set_the_resolution(pool, scale, density, side):
    """The floor of 2 m fills its map: 100 texels a metre take 200, in steps of 16."""
    floor = bpy.data.objects["Floor"]
    floor.scale = scale, scale, 1.0
    bpy.context.view_layer.update()
    assert side_in_metres(floor) == pytest.approx(2.0 * scale)
    pool.dapple.texels_per_metre = density
    assert request_from_scene(pool).settings.resolution == side
    pool.dapple.texels_per_metre = 0.0
    assert request_from_scene(pool).settings.resolution == 32
