"""Things of glass in Blender, over a floor, for tests."""

import bpy

from dapple.operators.read.extract import read_scene
from dapple.operators.read.mesh_arrays import TopologyCache
from dapple.tests.blender.small_pool import build_pool


def material(name, **values):
    """A Principled material; glass where nothing is said."""
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    shader = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    glass = {"Transmission Weight": 1.0, "Roughness": 0.0, "IOR": 1.5, "Base Color": (1, 1, 1, 1)}
    for key, value in {**glass, **values}.items():
        shader.inputs[key].default_value = value
    return made


def ball(name, *materials, smooth=True):
    """A ball above the middle of the floor, with materials."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.3, location=(0, 0, 2))
    made = bpy.context.object
    made.name = name
    made.data.polygons.foreach_set("use_smooth", [smooth] * len(made.data.polygons))
    for one in materials:
        made.data.materials.append(one)
    return made


def dry_floor(empty_scene, tmp_path):
    """A floor and a sun, no water."""
    build_pool(empty_scene, tmp_path / "out")
    bpy.data.objects.remove(bpy.data.objects["Water"])
    return empty_scene


def read(water=(), volume=None):
    """What `read_scene` returns."""
    return read_scene(bpy.context.evaluated_depsgraph_get(), water, ("Floor",), TopologyCache(), volume)
