"""Waters by every means that Blender has without a window: each builder makes one, 2 x 2 m at z = 0.6 or near it;
`shown_waters` has those that are instances, or of another file.

Builders take the scene and a folder and return the names of what is picked as water.
"""

import bpy
import numpy as np
import pytest

QUADS, SIZE, HEIGHT = 12, 2.0, 0.6
FRAMES = 1, 6


def surface(name, quads=QUADS, link=True, height=HEIGHT):
    """A smooth-shaded grid of quads x quads faces; returns the object."""
    axis = np.linspace(-SIZE / 2, SIZE / 2, quads + 1)
    x, y = np.meshgrid(axis, axis)
    i = np.arange((quads + 1) ** 2).reshape(quads + 1, quads + 1)
    faces = np.stack([i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3).tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    water = bpy.data.objects.new(name, mesh)
    water.location.z = height
    if link:
        bpy.context.scene.collection.objects.link(water)
    return water


def rippling(water):
    """A Wave modifier that moves on every frame."""
    wave = water.modifiers.new("Wave", "WAVE")
    wave.height, wave.width, wave.narrowness, wave.speed, wave.time_offset = 0.05, 0.6, 2.0, 0.05, -40
    return water


def wave(_scene, _folder):
    return (rippling(surface("Water")).name,)


def ocean(_scene, _folder):
    water = surface("Water", 2)
    ocean = water.modifiers.new("Ocean", "OCEAN")
    ocean.geometry_mode, ocean.resolution, ocean.viewport_resolution = "GENERATE", 4, 4
    ocean.size, ocean.spatial_size, ocean.wave_scale = 0.1, 20, 0.3
    for frame, time in zip(FRAMES, (0.0, 2.0)):
        ocean.time = time
        ocean.keyframe_insert("time", frame=frame)
    return (water.name,)


def displace(scene, _folder):
    water = surface("Water")
    texture = bpy.data.textures.new("Clouds", "CLOUDS")
    texture.noise_scale = 0.8
    modifier = water.modifiers.new("Displace", "DISPLACE")
    modifier.texture, modifier.strength, modifier.texture_coords = texture, 0.06, "OBJECT"
    modifier.texture_coords_object = guide = bpy.data.objects.new("Guide", None)
    scene.collection.objects.link(guide)
    _slide(guide)
    return (water.name,)


def _slide(thing):
    """Keyframes that move an object by 0.3 m from the first frame to the last."""
    for frame, x in zip(FRAMES, (0.0, 0.3)):
        thing.location.x = x
        thing.keyframe_insert("location", frame=frame)


def shape_keys(_scene, _folder):
    water = surface("Water")
    water.shape_key_add(name="Basis")
    raised = water.shape_key_add(name="Swell")
    for point in raised.data:
        point.co.z = 0.04 * np.cos(4 * point.co.x)
    for frame, value in zip(FRAMES, (0.2, 1.0)):
        raised.value = value
        raised.keyframe_insert("value", frame=frame)
    return (water.name,)


def armature(scene, _folder):
    """A bone that lifts the middle of the surface; another holds the rest."""
    water = surface("Water")
    bones = bpy.data.objects.new("Bones", bpy.data.armatures.new("Bones"))
    scene.collection.objects.link(bones)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    for name in ("Middle", "Rest"):
        bone = bones.data.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    middle, rest = (water.vertex_groups.new(name=name) for name in ("Middle", "Rest"))
    for vertex in water.data.vertices:
        share = float(np.exp(-4 * vertex.co.xy.length_squared))
        middle.add([vertex.index], share, "REPLACE")
        rest.add([vertex.index], 1 - share, "REPLACE")
    water.modifiers.new("Armature", "ARMATURE").object = bones
    pose = bones.pose.bones["Middle"]
    for frame, lift in zip(FRAMES, (0.02, 0.08)):
        pose.location.y = lift
        pose.keyframe_insert("location", frame=frame)
    return (water.name,)


def _nodes(name, water):
    """A geometry-nodes modifier on an object; returns its tree, its input's and its output's node."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    water.modifiers.new(name, "NODES").node_group = tree
    return tree, tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")


def _set_smooth(tree, geometry):
    smooth = tree.nodes.new("GeometryNodeSetShadeSmooth")
    tree.links.new(geometry, smooth.inputs[0])
    return smooth.outputs[0]


def _noisy(tree, geometry):
    """Lift the points of a geometry by noise that changes with time; returns the socket."""
    noise, move, lift = (
        tree.nodes.new(kind) for kind in ("ShaderNodeTexNoise", "GeometryNodeSetPosition", "ShaderNodeCombineXYZ")
    )
    noise.noise_dimensions = "4D"
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.5, 0.0
    noise.inputs["W"].driver_add("default_value").driver.expression = "frame / 10"
    scale = tree.nodes.new("ShaderNodeMath")
    scale.operation, scale.inputs[1].default_value = "MULTIPLY", 0.1
    tree.links.new(noise.outputs[0], scale.inputs[0])
    tree.links.new(scale.outputs[0], lift.inputs["Z"])
    tree.links.new(lift.outputs[0], move.inputs["Offset"])
    tree.links.new(geometry, move.inputs[0])
    return move.outputs[0]


def geometry_nodes(_scene, _folder):
    water = surface("Water")
    tree, enter, leave = _nodes("Noise", water)
    tree.links.new(_noisy(tree, enter.outputs[0]), leave.inputs[0])
    return (water.name,)


def geometry_nodes_mesh(_scene, _folder):
    """A mesh that only geometry nodes make, of other vertices on every frame, as that of a fluid."""
    water = bpy.data.objects.new("Water", bpy.data.meshes.new("Water"))
    bpy.context.scene.collection.objects.link(water)
    water.location.z = HEIGHT
    tree, _, leave = _nodes("Lattice", water)
    lattice = tree.nodes.new("GeometryNodeMeshGrid")
    for axis in "XY":
        lattice.inputs[f"Size {axis}"].default_value = SIZE
        driver = lattice.inputs[f"Vertices {axis}"].driver_add("default_value").driver
        driver.expression = "12 + frame"
    tree.links.new(_set_smooth(tree, _noisy(tree, lattice.outputs[0])), leave.inputs[0])
    return (water.name,)


def geometry_nodes_instances(_scene, _folder, realise=False):
    """Tiles of a surface that geometry nodes set side by side, as instances or made real."""
    tile = rippling(surface("Tile"))
    tile.location = 0, 0, -50
    water = bpy.data.objects.new("Water", bpy.data.meshes.new("Water"))
    bpy.context.scene.collection.objects.link(water)
    water.location.z = HEIGHT
    tree, _, leave = _nodes("Tiles", water)
    lattice, place = tree.nodes.new("GeometryNodeMeshGrid"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    model = tree.nodes.new("GeometryNodeObjectInfo")
    model.inputs["Object"].default_value = tile
    for axis in "XY":
        lattice.inputs[f"Size {axis}"].default_value = SIZE / 2
        lattice.inputs[f"Vertices {axis}"].default_value = 2
    place.inputs["Scale"].default_value = (0.5, 0.5, 0.5)
    tree.links.new(lattice.outputs[0], place.inputs["Points"])
    tree.links.new(model.outputs["Geometry"], place.inputs["Instance"])
    out = place.outputs[0]
    if realise:
        real = tree.nodes.new("GeometryNodeRealizeInstances")
        tree.links.new(out, real.inputs[0])
        out = real.outputs[0]
    tree.links.new(out, leave.inputs[0])
    tile.hide_render = True
    return (water.name,)


def geometry_nodes_realised(scene, folder):
    return geometry_nodes_instances(scene, folder, realise=True)


def metaballs(scene, _folder):
    """A drop that slides into a slab: polygonised anew on every frame, as the mesh of a fluid."""
    balls = []
    for name in ("Water", "Water.001"):
        data = bpy.data.metaballs.new(name)
        data.resolution = data.render_resolution = 0.12
        balls.append(bpy.data.objects.new(name, data))
        balls[-1].location.z = HEIGHT
        scene.collection.objects.link(balls[-1])
    slab, drop = balls[0].data.elements.new(type="CUBE"), balls[1].data.elements.new()
    slab.size_x = slab.size_y = 0.8
    slab.size_z, slab.radius, drop.radius = 0.01, 0.3, 0.4
    balls[1].location.z += 0.3
    _slide(balls[1])
    return (balls[0].name,)


def remesh(_scene, _folder):
    """A slab that is remeshed on every frame: other vertices in other numbers, closed, with a bottom."""
    water = rippling(surface("Water"))
    slab = water.modifiers.new("Slab", "SOLIDIFY")
    slab.thickness, slab.offset = 0.3, -1
    remesh = water.modifiers.new("Remesh", "REMESH")
    remesh.mode, remesh.use_smooth_shade = "VOXEL", True
    for frame, size in zip(FRAMES, (0.12, 0.11)):
        remesh.voxel_size = size
        remesh.keyframe_insert("voxel_size", frame=frame)
    return (water.name,)


def dynamic_paint(scene, _folder):
    """A wave surface that a moving ball stirs."""
    water = surface("Water", 16)
    canvas = water.modifiers.new("Canvas", "DYNAMIC_PAINT")
    bpy.context.view_layer.objects.active = water
    bpy.ops.dpaint.type_toggle(type="CANVAS")
    found = canvas.canvas_settings.canvas_surfaces[0]
    found.surface_type, found.frame_start, found.frame_end = "WAVE", 1, 20
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.3, location=(-0.4, 0, HEIGHT + 0.1))
    ball = bpy.context.object
    ball.name = "Ball"
    brush = ball.modifiers.new("Brush", "DYNAMIC_PAINT")
    brush.ui_type = "BRUSH"
    bpy.ops.dpaint.type_toggle(type="BRUSH")
    for frame, x in ((1, -0.4), (10, 0.6)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    ball.hide_render = True
    return (water.name,)


EXPORTERS = {"abc": "alembic_export", "usdc": "usd_export"}


def _cached(scene, folder, suffix, save, load):
    """A surface whose frames go to a cache file and come back as the only one in the scene."""
    if EXPORTERS[suffix] not in dir(bpy.ops.wm):
        pytest.skip(f"this Blender is built without .{suffix}")
    water = rippling(surface("Water"))
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    path = str(folder / f"water.{suffix}")
    save(path)
    bpy.data.objects.remove(water)
    before = set(bpy.data.objects)
    load(path)
    return tuple(sorted(o.name for o in set(bpy.data.objects) - before if o.type == "MESH"))


def alembic(scene, folder):
    return _cached(
        scene,
        folder,
        "abc",
        lambda path: bpy.ops.wm.alembic_export(filepath=path, start=1, end=6, as_background_job=False),
        lambda path: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
    )


def usd(scene, folder):
    return _cached(
        scene,
        folder,
        "usdc",
        lambda path: bpy.ops.wm.usd_export(filepath=path, export_animation=True, export_lights=False),
        lambda path: bpy.ops.wm.usd_import(filepath=path, import_lights=False),
    )


def two_surfaces(_scene, _folder):
    """Two basins side by side, each a half."""
    names = []
    for side in (-1, 1):
        half = rippling(surface(f"Basin {side}"))
        half.scale.x, half.location.x = 0.5, side * SIZE / 4
        names.append(half.name)
    return tuple(names)


def parented(scene, _folder):
    """A surface that a moving Empty carries."""
    raft = bpy.data.objects.new("Raft", None)
    scene.collection.objects.link(raft)
    water = surface("Water")
    water.parent = raft
    _slide(raft)
    return (rippling(water).name,)
