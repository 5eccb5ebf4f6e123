"""What the build scripts share: an empty scene, materials from a few nodes, meshes with explicit UVs, saving.

Runs under any bpy from 4.2 on; a file that is to open everywhere is written by the oldest.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent
FPS = 24
FRAMES = 48


def load_dapple():
    """Import the working tree as the package `dapple` and register the add-on."""
    path = ROOT / "__init__.py"
    spec = importlib.util.spec_from_file_location("dapple", path, submodule_search_locations=[str(ROOT)])
    package = sys.modules["dapple"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    package.register()


def new_scene():
    """Empty the session and return its scene: 960x540, EEVEE, 48 frames at 24 frames a second, with `scene.dapple`."""
    if "dapple" not in sys.modules:
        load_dapple()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    engines = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    scene.render.engine = "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in engines else "BLENDER_EEVEE"
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    scene.render.fps = FPS
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.frame_set(1)
    scene.view_settings.view_transform = "AgX"
    scene.eevee.use_raytracing = True
    scene.eevee.ray_tracing_options.resolution_scale = "1"
    # Refracted rays are traced on the screen: without a margin they leave it near the picture's border.
    scene.eevee.use_overscan = True
    scene.eevee.overscan_size = 15.0
    # A ray that dives into the water runs far behind what the camera sees in front of it.
    scene.eevee.ray_tracing_options.screen_trace_thickness = 2.0
    scene.eevee.ray_tracing_options.screen_trace_quality = 1.0
    return scene


def add_collection(name, *objects):
    """Make a collection that holds `objects`, which are moved there from the scene's own."""
    collection = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(collection)
    for obj in objects:
        bpy.context.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    return collection


def add_object(name, data):
    """Make an object of `data` and link it to the scene."""
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_mesh(name, positions, faces, materials=(), smooth=False):
    """Make a mesh object from positions (V,3) [m] and faces, lists of indices."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(positions, float).tolist(), [], [list(map(int, face)) for face in faces])
    mesh.polygons.foreach_set("use_smooth", np.full(len(mesh.polygons), smooth))
    for material in materials:
        mesh.materials.append(material)
    mesh.update()
    return add_object(name, mesh)


def add_grid(name, size, cells, height, materials=()):
    """Make a smooth square grid of cells x cells quads about the origin; height(x, y) -> z, all [m]."""
    line = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(line, line)
    positions = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    faces = np.stack([corner, corner + 1, corner + cells + 2, corner + cells + 1], axis=-1)
    return add_mesh(name, positions, faces, materials, smooth=True)


def add_uvs(mesh, uvs, name="Lightmap"):
    """Give `mesh` a UV map, uvs (corners, 2), that is the one in use and the one rendered."""
    layer = mesh.uv_layers.new(name=name)
    layer.data.foreach_set("uv", np.asarray(uvs, np.float32).ravel())
    layer.active = layer.active_render = True


def add_sun(direction, strength, degrees):
    """Make a Sun lamp that shines along `direction` with a disc of `degrees`, ready for Cycles' shadow caustics."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy = strength
    data.angle = np.radians(degrees)
    data.cycles.is_caustics_light = True
    sun = add_object("Sun", data)
    sun.rotation_euler = Vector(direction).to_track_quat("-Z", "Y").to_euler()
    sun.location = (0.0, 0.0, 6.0)
    return sun


def add_camera(name, position, target, lens):
    """Make a camera at `position` that looks at `target`, both [m], with a lens in millimetres."""
    data = bpy.data.cameras.new(name)
    data.lens = lens
    data.clip_start = 0.01
    camera = add_object(name, data)
    camera.location = position
    camera.rotation_euler = (Vector(target) - Vector(position)).to_track_quat("-Z", "Y").to_euler()
    return camera


def add_box(name, middle, half):
    """Make an Empty, drawn as a cube, that bounds a box: its middle and half its sides [m]."""
    box = add_object(name, None)
    box.empty_display_type, box.location, box.scale = "CUBE", middle, half
    return box


def ball(radius, around, upward):
    """Return the positions and faces of a ball of `around` meridians and `upward` bands, quads but at the poles."""
    azimuth = np.arange(around) * 2 * np.pi / around
    polar = np.arange(1, upward) * np.pi / upward
    height, across = -np.cos(polar)[:, None], np.sin(polar)[:, None]
    rings = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), height + 0 * azimuth], axis=-1)
    positions = np.concatenate([rings.reshape(-1, 3), [(0, 0, -1), (0, 0, 1)]]) * radius
    i, j = np.arange(around), (np.arange(around) + 1) % around
    faces = [np.stack([i, j, j + around, i + around], axis=-1) + k * around for k in range(upward - 2)]
    last, south = (upward - 2) * around, (upward - 1) * around
    return positions, [
        *np.concatenate(faces),
        *np.stack([j, i, np.full(around, south)], axis=-1),
        *np.stack([last + i, last + j, np.full(around, south + 1)], axis=-1),
    ]


def torus_faces(around, across):
    """Return the quads (F,4) between `around` closed profiles of `across` points, which close on themselves."""
    i, j = (index.ravel() for index in np.indices((around, across)))
    next_i, next_j = (i + 1) % around, (j + 1) % across
    return np.stack([i * across + j, next_i * across + j, next_i * across + next_j, i * across + next_j], axis=-1)


def move_evenly(obj):
    """Let what is keyed of an object go from key to key at one speed, and on beyond the last."""
    for curve in fcurves(obj):
        curve.extrapolation = "LINEAR"
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


def fcurves(obj):
    """Return the curves of an object's action, in the layers that Blender has since 4.4 too."""
    action = obj.animation_data.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return [c for layer in action.layers for strip in layer.strips for bag in strip.channelbags for c in bag.fcurves]


def add_node(tree, kind, values=None, **attributes):
    """Add a node; `values`: input name or index -> a default, or an output socket to link."""
    node = tree.nodes.new(kind)
    for key, value in attributes.items():
        setattr(node, key, value)
    for key, value in (values or {}).items():
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, node.inputs[key])
        else:
            node.inputs[key].default_value = value
    return node


def new_material(name):
    """Make a material; returns it with its empty node tree's Principled BSDF, linked to the output."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = add_node(tree, "ShaderNodeBsdfPrincipled")
    add_node(tree, "ShaderNodeOutputMaterial", {"Surface": shader.outputs["BSDF"]})
    return material, shader


def new_plain(name, colour, roughness=0.4, specular=0.3):
    """Make a material of one colour, linear RGB."""
    material, shader = new_material(name)
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Specular IOR Level"].default_value = specular
    return material


def new_water(name="Water", ior=1.333):
    """Make clear water that EEVEE refracts by tracing rays, and whose shadow is opaque there."""
    material, shader = new_material(name)
    shader.inputs["Base Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    shader.inputs["Roughness"].default_value = 0.0
    shader.inputs["IOR"].default_value = ior
    shader.inputs["Transmission Weight"].default_value = 1.0
    material.surface_render_method = "DITHERED"
    material.use_raytrace_refraction = True
    material.use_transparent_shadow = False
    return material


def new_speckled(name, scale, detail, dark, light):
    """Make a rough, matt material whose colour wanders between two, by noise of a scale [1/m] and detail."""
    material, shader = new_material(name)
    tree = material.node_tree
    place = add_node(tree, "ShaderNodeTexCoord").outputs["Object"]
    noise = add_node(tree, "ShaderNodeTexNoise", {"Vector": place, "Scale": scale, "Detail": detail}).outputs[0]
    ramp = add_node(tree, "ShaderNodeValToRGB", {"Fac": noise})
    for stop, colour in zip(ramp.color_ramp.elements, (dark, light), strict=True):
        stop.color = (*colour, 1.0)
    tree.links.new(ramp.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.9
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def new_glass(name, ior, colour=(1.0, 1.0, 1.0)):
    """Make smooth glass that EEVEE refracts by tracing rays; a body of it shows the colour, linear RGB."""
    material = new_water(name, ior)
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    material.thickness_mode = "SPHERE"
    return material


def new_metal(name, colour):
    """Make polished metal of one colour, linear RGB."""
    material = new_plain(name, colour, roughness=0.0, specular=0.5)
    next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Metallic"].default_value = 1.0
    return material


def set_sky(horizon, zenith, strength):
    """Light the scene by a gradient from the horizon's colour to the zenith's, linear RGB."""
    world = bpy.data.worlds.new("Sky")
    bpy.context.scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    direction = add_node(tree, "ShaderNodeTexCoord").outputs["Generated"]
    height = add_node(tree, "ShaderNodeSeparateXYZ", {0: direction}).outputs["Z"]
    ramp = add_node(tree, "ShaderNodeValToRGB", {"Fac": height})
    for element, colour in zip(ramp.color_ramp.elements, (horizon, zenith), strict=True):
        element.color = (*colour, 1.0)
    background = add_node(tree, "ShaderNodeBackground", {"Color": ramp.outputs["Color"], "Strength": strength})
    add_node(tree, "ShaderNodeOutputWorld", {"Surface": background.outputs[0]})


def choose(water, receivers, casters=()):
    """Set what Dapple bakes, and tell Cycles who casts shadow caustics and who takes them; water may be None."""
    bpy.context.scene.dapple.water = water
    bpy.context.scene.dapple.receivers = add_collection("Receivers", *receivers)
    for caster in (*([water] if water else []), *casters):
        caster.cycles.is_caustics_caster = True
    for receiver in receivers:
        receiver.cycles.is_caustics_receiver = True


def save(name):
    """Write the session to sample_blends/<name>, compressed and without a backup, and end the process."""
    bpy.context.scene.dapple.output = f"//{Path(name).stem}_caustics"
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / name), compress=True, relative_remap=True)
    print(f"{name}: {(FOLDER / name).stat().st_size / 1e6:.2f} MB, Blender {bpy.app.version_string}")
    # As a module, Blender 4.2 crashes on its way out once an add-on's classes were registered: leave at once.
    sys.stdout.flush()
    os._exit(0)
