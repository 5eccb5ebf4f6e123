"""A pool of two quads, for tests of what people press."""

import bpy


def pool(scene):
    """Water over one receiver, in a nested collection, under a Sun."""
    receivers, inner = bpy.data.collections.new("Receivers"), bpy.data.collections.new("Inner")
    receivers.children.link(inner)
    scene.collection.children.link(receivers)
    quad(scene.collection, "Water", 1.0, 1.5)
    quad(inner, "Floor", 0.0, 1.0)
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle = 1.0, 0.0
    scene.collection.objects.link(lamp)
    scene.dapple.water = bpy.data.objects["Water"]
    scene.dapple.receivers = receivers


def quad(collection, name, height, half):
    mesh = bpy.data.meshes.new(name)
    corners = [(-half, -half, height), (half, -half, height), (half, half, height), (-half, half, height)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    collection.objects.link(bpy.data.objects.new(name, mesh))
