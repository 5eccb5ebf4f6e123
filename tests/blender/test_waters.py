"""Water by every means that Blender has without a window is baked alike: as the closed form and a plain mesh have it.

Not here: the Mantaflow solver, which no background Blender runs in a test's time. What it hands over, a mesh of other
vertices on every frame, is that of `remesh`, `metaballs` and `geometry_nodes_mesh`.
"""

import json

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from dapple.kernels.scene import Settings
from dapple.operators.bake.bake import BakeRequest, bake, request_from_scene
from dapple.operators.read.caches import Player
from dapple.operators.read.extract import read_scene
from dapple.operators.read.find import find_object
from dapple.operators.read.mesh_arrays import TopologyCache
from dapple.tests.blender import shown_waters, waters
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import add_grid
from dapple.tests.waves import transmitted

SHEETS = (
    waters.wave,
    waters.displace,
    waters.shape_keys,
    waters.armature,
    waters.geometry_nodes,
    waters.geometry_nodes_mesh,
    waters.geometry_nodes_instances,
    waters.geometry_nodes_realised,
    waters.dynamic_paint,
    waters.alembic,
    waters.usd,
    waters.two_surfaces,
    shown_waters.collection_instance,
    shown_waters.surface_behind_an_instance,
    shown_waters.several_instances,
    shown_waters.nested_instances,
    shown_waters.linked_collection_instance,
    shown_waters.linked_object,
    shown_waters.library_override,
    shown_waters.linked_mesh,
    waters.parented,
)
# What is not a sheet over 2 x 2 m: water with a bottom, through which light passes twice, and what moves to the sides.
BODIES = (waters.ocean, waters.remesh, waters.metaballs)

SAME = 1e-3  # relMSE of two bakes of one water, in quads and in triangles: Blender's normals differ


def lit(scene, folder, build):
    """The names of water that is built over a floor that takes all of its light, under a sun straight above."""
    names = build(scene, folder)
    add_grid("Floor", 0.0).scale = 1.5, 1.5, 1.0
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy = 1.0
    scene.collection.objects.link(bpy.data.objects.new("Sun", sun))
    return names


def baked(names, frames, out):
    """Images and entries in bake.json of frames, which are baked without a warning."""
    steps = bake(bpy.context, BakeRequest(names, ("Floor",), frames, out, Settings(resolution=48)))
    steps = sorted(steps, key=lambda step: step.frame)  # with several workers a later frame may be done first
    assert [warning for step in steps for warning in step.warnings] == []
    record = json.loads((out / "bake.json").read_text())["frames"]
    return [read_exr(step.maps[0]).astype(float) for step in steps], [record[str(frame)] for frame in frames]


def made_plain(names):
    """A mesh without modifiers of the water that the current frame shows, in its own polygons where it is one object,
    else in triangles; returns its name."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    shown = find_object(names[0]).evaluated_get(depsgraph)
    if len(names) == 1 and (shown.type == "META" or (shown.type == "MESH" and len(shown.data.polygons))):
        mesh, matrix = bpy.data.meshes.new_from_object(shown, depsgraph=depsgraph), shown.matrix_world.copy()
    else:
        water = read_scene(depsgraph, names, ("Floor",), TopologyCache())[0].water
        mesh, matrix = bpy.data.meshes.new("Plain"), Matrix.Identity(4)
        mesh.from_pydata(water.positions.tolist(), [], water.triangles.tolist())
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    plain = bpy.data.objects.new("Plain", mesh)
    plain.matrix_world = matrix
    bpy.context.scene.collection.objects.link(plain)
    return ("Plain",)


@pytest.mark.parametrize("build", (*SHEETS, *BODIES), ids=lambda build: build.__name__)
def test_water(empty_scene, tmp_path, build):
    names = lit(empty_scene, tmp_path, build)
    (first, last), entries = baked(names, waters.FRAMES, tmp_path / "out")
    assert np.abs(first - last).mean() > 3e-3  # it moves
    for entry in entries:
        inward, received = np.array(entry["flux_in"]), np.array(entry["flux_received"]["Floor"])
        lost = sum(map(np.array, entry["flux_lost"].values()))
        np.testing.assert_allclose(received + lost, inward, rtol=1e-6)
        if build in SHEETS:
            np.testing.assert_allclose(inward, waters.SIZE**2, rtol=1e-4)
            np.testing.assert_allclose(received / inward, transmitted(1.0), rtol=5e-4)
    Player(empty_scene.name).go(waters.FRAMES[-1])
    plain = made_plain(names)
    for obj in empty_scene.objects:
        obj.hide_viewport = obj.hide_render = obj.name not in ("Floor", "Sun", *plain)
    (again,), _ = baked(plain, waters.FRAMES[-1:], tmp_path / "plain")
    error = ((again - last) ** 2).mean() / (last**2).mean()
    assert error < SAME


def test_water_with_a_bottom_passes_light_twice(empty_scene, tmp_path):
    names = lit(empty_scene, tmp_path, waters.remesh)
    _, (entry,) = baked(names, (6,), tmp_path / "out")
    assert entry["flux_received"]["Floor"][0] / entry["flux_in"][0] == pytest.approx(transmitted(1.0) ** 2, rel=0.01)


@pytest.mark.parametrize("build", [waters.remesh, waters.metaballs, waters.geometry_nodes_mesh])
def test_vertices_change_in_number(empty_scene, tmp_path, build):
    """What `test_water` takes for meshes of changing topology are such."""
    names, counts = lit(empty_scene, tmp_path, build), set()
    for frame in waters.FRAMES:
        empty_scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        counts.add(len(read_scene(depsgraph, names, ("Floor",), TopologyCache())[0].water.positions))
    assert len(counts) == 2


def test_normals_of_a_cache_that_say_nothing_new_are_smooth(empty_scene, tmp_path):
    """USD hands over a normal a corner, as if set by hand, also of what is shaded smooth."""
    names = lit(empty_scene, tmp_path, waters.usd)
    assert bpy.data.objects[names[0]].data.has_custom_normals
    depsgraph = bpy.context.evaluated_depsgraph_get()
    water = read_scene(depsgraph, names, ("Floor",), TopologyCache())[0].water
    assert water.normal_triangles is water.triangles


def test_things_that_float_on_water_are_no_water(empty_scene, tmp_path):
    """Instances on a water with a mesh of its own block light: the floor loses what they stand over."""
    (name,) = lit(empty_scene, tmp_path, waters.wave)
    (before,), _ = baked((name,), (1,), tmp_path / "before")
    bpy.ops.mesh.primitive_plane_add(size=0.5)
    leaf = bpy.context.object
    leaf.parent = bpy.data.objects[name]
    bpy.data.objects[name].instance_type = "VERTS"
    scene, warnings = read_scene(bpy.context.evaluated_depsgraph_get(), (name,), ("Floor",), TopologyCache())
    assert len(scene.occluders) == (waters.QUADS + 1) ** 2
    assert warnings == []
    assert len(scene.water.positions) == (waters.QUADS + 1) ** 2
    (step,) = bake(bpy.context, BakeRequest((name,), ("Floor",), (1,), tmp_path / "after", Settings(resolution=48)))
    assert read_exr(step.maps[0]).mean() < 0.1 * before.mean()


def test_several_waters_are_picked_by_their_own_settings(empty_scene, tmp_path):
    first, second = lit(empty_scene, tmp_path, waters.two_surfaces)
    settings = empty_scene.dapple
    settings.water, settings.output = bpy.data.objects[first], str(tmp_path)
    settings.receivers = bpy.data.collections.new("Receivers")
    settings.receivers.objects.link(bpy.data.objects["Floor"])
    assert request_from_scene(empty_scene).water == (first,)
    bpy.data.objects[second].dapple.caustics = "WATER"
    assert request_from_scene(empty_scene).water == (first, second)
    settings.water = None
    assert request_from_scene(empty_scene).water == (second,)
