"""Meshes and lamps made in Blender, read as a bake reads them, for tests."""

import bpy
import numpy as np

from dapple.operators.read.extract import read_scene
from dapple.operators.read.mesh_arrays import TopologyCache


def add(mesh_name, data):
    """An object of some data, linked to the scene."""
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
    """A Sun lamp."""
    light = bpy.data.lights.new("Sun", "SUN")
    light.energy = energy
    lamp = add("Sun", light)
    lamp.rotation_euler = rotation
    return lamp


def read(water=("Water",), receivers=("Floor",), topology=None):
    """What `read_scene` returns."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return read_scene(depsgraph, water, receivers, topology or TopologyCache())


def floor_and_sun(scene):
    """The scene with a floor and a sun; each test brings its own water."""
    grid("Floor", z=-5.0)
    sun()
    return scene
