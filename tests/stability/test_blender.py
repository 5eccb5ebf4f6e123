"""What only Blender's side can spoil: transforms, distances, winding, topology, broken vertices. Baked, then read back.

The answer is that of photons, traced through the arrays of the scene as it should be.
"""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector
from waves import OBLIQUE, calm, pool

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.tests.blender.conftest import empty_scene  # noqa: F401
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.stability.judge import COMPLETE, METHODS, NOT_MEANS, ONE_PATH, SAMPLED, Verdict, judge
from dapple.tests.stability.photons import trace

SIDE = 16
QUADS = 48
HOME = np.zeros(3)


def add_mesh(name, positions, faces, origin=HOME):
    """A smooth-shaded object of world positions (V,3), its origin at `origin`."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((np.asarray(positions) - origin).tolist(), [], np.asarray(faces).tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    thing = bpy.data.objects.new(name, mesh)
    thing.location = origin
    bpy.context.scene.collection.objects.link(thing)
    return thing


def build(scene, out, shift=HOME, origin=HOME, scale=1.0):
    """The pool under calm waves, `scale` times its size and moved by `shift`, objects' origins at `origin`; returns the
    water's object and what its map should be."""
    known = pool(calm, quads=QUADS, direction=OBLIQUE)
    surface = add_mesh("Water", scale * known.water.positions + shift, known.water.triangles, origin)
    bed = known.receivers[0]
    ground = add_mesh("Floor", scale * bed.positions + shift, bed.triangles, origin)
    layer = ground.data.uv_layers.new(name="UVMap")
    layer.uv.foreach_set("vector", bed.uvs.astype(np.float32).ravel())
    receivers = bpy.data.collections.new("Receivers")
    scene.collection.children.link(receivers)
    receivers.objects.link(ground)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle = 1.0, 0.0
    lamp.rotation_euler = (-Vector(OBLIQUE)).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(lamp)
    settings = scene.dapple
    settings.water, settings.receivers = surface, receivers
    settings.resolution, settings.output = SIDE, str(out)
    return surface, trace(with_blenders_normals(known), SIDE)


def with_blenders_normals(scene):
    """The scene with the vertex normals that Blender gives its water."""
    mesh = bpy.data.meshes.new("At home")
    mesh.from_pydata(scene.water.positions.tolist(), [], scene.water.triangles.tolist())
    normals = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertex_normals.foreach_get("vector", normals.ravel())
    return replace(scene, water=replace(scene.water, normals=normals.astype(float)))


def baked(scene, method, frames=(1,), out=None):
    """Maps (n,H,W) and the last frame's entry in bake.json, by one of METHODS on the mesh as it is."""
    request = request_from_scene(scene, frames=frames, out=out)
    points = 8 if METHODS[method].first_root else 1
    settings = replace(METHODS[method], surface="mesh", resolution=SIDE * points)
    list(bake(bpy.context, replace(request, settings=settings)))
    maps = [read_exr(request.out / "Floor" / f"caustics_{n:04d}.exr").astype(float) for n in frames]
    maps = [m.reshape(SIDE, points, SIDE, points, 3).mean((1, 3)) for m in maps]
    return maps, json.loads((request.out / "bake.json").read_text())["frames"][str(frames[-1])]


def every_method(row, scene, expected, right=COMPLETE, sentence=None, tolerance=1e-3, worst=0.06):
    """Judge the bakes of all methods, as the fixture of that name judges solutions."""
    row.tolerance = f"{tolerance:g}, {worst:g}"
    bad = []
    for method, settings in METHODS.items():
        (image,), entry = baked(scene, method)
        told = [*entry["left_out"], *entry["warnings"]]
        status = np.ones((SIDE, SIDE), np.uint8)
        allowed = (tolerance + 4 * settings.tolerance, 0.5) if method in SAMPLED else (tolerance, worst)
        verdict = judge([image], [status], told, expected, *allowed, [sentence or ONE_PATH, NOT_MEANS])
        row.cells[method] = verdict
        if verdict.outcome == "wrong" or (verdict.outcome == "reported" and method in right):
            bad.append(f"{method}: {verdict.outcome}, {verdict.why}")
    assert not bad, "; ".join(bad)


TRANSFORMS = {
    "as it is": Matrix.Identity(4),
    "stretched and turned": Matrix.LocRotScale(Vector((3, -2, 1)), Euler((0.4, -0.7, 1.1)), Vector((2.0, 0.5, 0.25))),
    "mirrored": Matrix.Diagonal(Vector((-1.0, 1.0, 1.0, 1.0))),
    "a thousandth": Matrix.Scale(1e-3, 4),
}


@pytest.mark.parametrize("name", TRANSFORMS)
def test_objects_under_any_scale(row, empty_scene, tmp_path, name):  # noqa: F811
    """An object whose scale is not applied

    The object's matrix is undone in its mesh, so that the water in the world is the same: photons.
    """
    surface, expected = build(empty_scene, tmp_path)
    surface.data.transform(TRANSFORMS[name].inverted())
    surface.matrix_world = TRANSFORMS[name]
    every_method(row, empty_scene, expected)


@pytest.mark.parametrize("flipped", ["all", "a quarter"])
def test_faces_flipped(row, empty_scene, tmp_path, flipped):  # noqa: F811
    """Faces wound the wrong way round

    Where all are, the surface is the same from below: photons. Where a patch is, its normals point down as those of the
    far side of a body of water do, and the record must say that the water is wound against itself.
    """
    surface, expected = build(empty_scene, tmp_path)
    for polygon in surface.data.polygons:
        if flipped == "all" or min(polygon.center.xy) > 0:
            polygon.flip()
    surface.data.update()
    if flipped == "all":
        every_method(row, empty_scene, expected)
    else:
        every_method(row, empty_scene, expected, (), "wound against")


def test_far_from_the_worlds_origin(row, empty_scene, tmp_path):  # noqa: F811
    """Objects 100 km from the world's origin, each with its own origin there

    Their meshes are as exact as at home, and only their place is rounded, to 8 mm: photons of the pool at home.
    """
    far = np.array([1e5, -1e5, 1e5])
    _, expected = build(empty_scene, tmp_path, shift=far, origin=far)
    every_method(row, empty_scene, expected)


def test_vertices_far_from_their_origin(row, empty_scene, tmp_path):  # noqa: F811
    """Vertices 100 km from their object's origin

    Blender rounds them to 8 mm, which is steeper than the waves: no bake can tell them any more, and that is said.
    """
    _, expected = build(empty_scene, tmp_path, shift=np.array([1e5, -1e5, 1e5]))
    every_method(row, empty_scene, expected, (), "where Blender rounds them")


def test_a_pool_of_a_millimetre(row, empty_scene, tmp_path):  # noqa: F811
    """A pool whose floor is 1 mm wide

    Refraction knows no lengths: the photons of the pool of 4 m.
    """
    _, expected = build(empty_scene, tmp_path, scale=2.5e-4)
    every_method(row, empty_scene, expected)


def test_topology_that_changes_every_frame(row, empty_scene, tmp_path):  # noqa: F811
    """Water whose triangles change on every frame

    Nothing of a frame may be kept for the next: each map is, to the bit, what a bake of that frame alone gives.
    """
    row.tolerance = "0"
    surface, _ = build(empty_scene, tmp_path / "unused")
    thinned = surface.modifiers.new("Thinned", "DECIMATE")
    for frame, ratio in ((1, 1.0), (2, 0.6), (3, 0.8), (4, 0.8)):
        thinned.ratio = ratio
        thinned.keyframe_insert("ratio", frame=frame)
    counts = set()
    for method in METHODS:
        together, _ = baked(empty_scene, method, (1, 2, 3, 4), tmp_path / "together" / method)
        for frame, image in zip((1, 2, 3, 4), together, strict=True):
            alone, entry = baked(empty_scene, method, (frame,), tmp_path / f"alone {frame}" / method)
            counts.add(entry["paths"].get("beams"))
            np.testing.assert_array_equal(image, alone[0])
        row.cells[method] = Verdict("right", "", 0.0)
    assert len(counts) > 3, "the mesh must change, or the test shows nothing"


@pytest.mark.parametrize("who", ["Water", "Floor"])
def test_vertices_that_are_no_numbers(row, empty_scene, tmp_path, who):  # noqa: F811
    """A vertex that is no number

    There is no such surface: the bake stops with a sentence that names the object, and writes nothing.
    """
    row.tolerance = "no map"
    build(empty_scene, tmp_path)
    bpy.data.objects[who].data.vertices[2].co.z = np.nan
    for method in METHODS:
        with pytest.raises(DappleError, match=rf"'{who}' has coordinates that are not numbers at 1 of its") as caught:
            baked(empty_scene, method)
        row.cells[method] = Verdict("reported", str(caught.value), 0.0)
    assert not list(tmp_path.iterdir())
