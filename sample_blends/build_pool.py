"""Build pool.blend: a tiled pool with steps and a floating ring under five travelling sines.

Run as `python sample_blends/build_pool.py` with bpy 4.2 or later; the committed file is written by 4.2, which every
later Blender opens. The pool is 4 x 4 x 1.5 m; its floor lies at z = 0. The water is moved by geometry nodes:

    z = 1.5 + sum A sin(k (x cos a + y sin a) - w t + p),  k = 2 pi / wavelength,  t = (frame - 1) / 24 s

In deep water w = sqrt(9.81 k). Here each w is rounded to the nearest multiple of pi rad/s (by 15 % at the most), so
that all five return after 2 s and the 48 frames loop.
"""

from __future__ import annotations

import bpy
import numpy as np
import pool_geometry as geometry
import scene_tools as tools

# amplitude [m], wavelength [m], direction [degrees], phase [rad]
WAVES = (
    (0.020, 1.60, 20.0, 0.0),
    (0.012, 0.90, 75.0, 1.3),
    (0.010, 0.62, -40.0, 2.1),
    (0.006, 0.37, 130.0, 0.7),
    (0.004, 0.23, -100.0, 4.0),
)
LOOP = tools.FRAMES / tools.FPS
GRAVITY = 9.81
WATER_SIZE, WATER_CELLS = 4.2, 128
SUN = (0.25, 0.1, -1.0)


def angular_frequency(wavelength):
    """Return w [rad/s] of a gravity wave, rounded so that it repeats after the loop."""
    step = 2.0 * np.pi / LOOP
    return step * round(np.sqrt(GRAVITY * 2.0 * np.pi / wavelength) / step)


def add_sine(tree, position, seconds, wave):
    """Add the nodes of one travelling sine and return the socket of its height [m]."""
    amplitude, wavelength, degrees, phase = wave
    k, angle, w = 2.0 * np.pi / wavelength, np.radians(degrees), angular_frequency(wavelength)
    vector = (k * np.cos(angle), k * np.sin(angle), 0.0)
    along = tools.add_node(tree, "ShaderNodeVectorMath", {0: position, 1: vector}, operation="DOT_PRODUCT")
    # Frame 1 is t = 0, but the scene's clock then stands at one frame.
    start = phase + w / tools.FPS
    turn = tools.add_node(tree, "ShaderNodeMath", {0: seconds, 1: -w, 2: start}, operation="MULTIPLY_ADD")
    total = tools.add_node(tree, "ShaderNodeMath", {0: along.outputs["Value"], 1: turn.outputs[0]}, operation="ADD")
    sine = tools.add_node(tree, "ShaderNodeMath", {0: total.outputs[0]}, operation="SINE")
    return tools.add_node(tree, "ShaderNodeMath", {0: sine.outputs[0], 1: amplitude}, operation="MULTIPLY").outputs[0]


def wave_nodes(waves):
    """Make the node group that lifts a flat mesh by the sum of sines, rows as those of WAVES."""
    tree = bpy.data.node_groups.new("Sines", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    mesh = tools.add_node(tree, "NodeGroupInput").outputs[0]
    position = tools.add_node(tree, "GeometryNodeInputPosition").outputs[0]
    seconds = tools.add_node(tree, "GeometryNodeInputSceneTime").outputs["Seconds"]
    height = add_sine(tree, position, seconds, waves[0])
    for wave in waves[1:]:
        sine = add_sine(tree, position, seconds, wave)
        height = tools.add_node(tree, "ShaderNodeMath", {0: height, 1: sine}, operation="ADD").outputs[0]
    offset = tools.add_node(tree, "ShaderNodeCombineXYZ", {"Z": height}).outputs[0]
    moved = tools.add_node(tree, "GeometryNodeSetPosition", {"Geometry": mesh, "Offset": offset})
    tools.add_node(tree, "NodeGroupOutput", {0: moved.outputs[0]})
    return tree


def add_water():
    """Make the water: a grid that reaches 0.1 m into the walls, so that its rim is out of sight and out of the sun."""
    water = tools.add_grid("Water", WATER_SIZE, WATER_CELLS, lambda x, _: 0.0 * x, [tools.new_water()])
    water.location.z = geometry.DEPTH
    water.modifiers.new("Waves", "NODES").node_group = wave_nodes(WAVES)
    return water


def tile_coordinates():
    """Make the shader group that lays world x, y, z flat on any axis-aligned face: metres along it in X and Y."""
    tree = bpy.data.node_groups.new("Tile Coordinates", "ShaderNodeTree")
    tree.interface.new_socket("Vector", in_out="OUTPUT", socket_type="NodeSocketVector")
    surface = tools.add_node(tree, "ShaderNodeNewGeometry")
    normal = tools.add_node(tree, "ShaderNodeVectorMath", {0: surface.outputs["True Normal"]}, operation="ABSOLUTE")
    facing = tools.add_node(tree, "ShaderNodeSeparateXYZ", {0: normal.outputs[0]})
    place = tools.add_node(tree, "ShaderNodeSeparateXYZ", {0: surface.outputs["Position"]})
    flat = tools.add_node(tree, "ShaderNodeCombineXYZ")
    # Faces along x show (y, z), along y (x, z), along z (x, y).
    for target, weight, yes, no in (("X", "X", "Y", "X"), ("Y", "Z", "Y", "Z")):
        mix = tools.add_node(
            tree, "ShaderNodeMix", {0: facing.outputs[weight], 2: place.outputs[no], 3: place.outputs[yes]}
        )
        tree.links.new(mix.outputs[0], flat.inputs[target])
    tools.add_node(tree, "NodeGroupOutput", {0: flat.outputs[0]})
    return tree


def new_tiles(name, group, size, colours, joint, offset=0.0):
    """Make tiles of `size` (w, h) [m] whose colours vary between two, with a joint's colour and width [m]."""
    material, shader = tools.new_material(name)
    tree = material.node_tree
    where = tools.add_node(tree, "ShaderNodeGroup", node_tree=group).outputs[0]
    bricks = {"Vector": where, "Scale": 1.0, "Mortar Size": joint[1] / 2, "Mortar Smooth": 0.2}
    bricks |= {"Brick Width": size[0], "Row Height": size[1], "Mortar": (*joint[0], 1.0)}
    bricks |= {"Color1": (*colours[0], 1.0), "Color2": (*colours[1], 1.0)}
    pattern = tools.add_node(tree, "ShaderNodeTexBrick", bricks, offset=offset, squash=1.0)
    tree.links.new(pattern.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.5
    # Under water a tile's index is close to that of what surrounds it: it hardly shines.
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def add_receivers(group):
    """Make the floor, the walls and the steps."""
    pale, grout = ((0.50, 0.72, 0.78), (0.34, 0.60, 0.70)), ((0.78, 0.84, 0.84), 0.010)
    floor = new_tiles("Floor Tiles", group, (0.2, 0.2), pale, grout)
    walls = new_tiles("Wall Tiles", group, (0.2, 0.2), pale, grout)
    band = new_tiles("Waterline Tiles", group, (0.1, 0.1), ((0.03, 0.13, 0.34), (0.05, 0.24, 0.46)), grout)
    steps = new_tiles("Step Tiles", group, (0.2, 0.1), ((0.72, 0.76, 0.74), (0.62, 0.70, 0.70)), grout)
    charts = (
        ("Floor", geometry.floor(), [floor]),
        ("Walls", geometry.walls(), [walls, band]),
        ("Steps", geometry.steps(), [steps, band]),
    )
    return [geometry.add_receiver(*chart) for chart in charts]


def add_surroundings(group):
    """Make what only blocks light: the coping and the deck round the pool, and the ring."""
    stone = new_tiles("Stone", group, (0.5, 0.5), ((0.62, 0.58, 0.52), (0.54, 0.50, 0.45)), ((0.3, 0.28, 0.26), 0.008))
    paving = ((0.46, 0.36, 0.27), (0.38, 0.30, 0.23))
    deck = new_tiles("Paving", group, (0.6, 0.3), paving, ((0.22, 0.20, 0.18), 0.012), offset=0.5)
    ring = geometry.add_ring(
        [tools.new_plain("Red", (0.70, 0.05, 0.03), 0.3, 0.5), tools.new_plain("White", (0.8,) * 3)]
    )
    for frame, height in ((1, 0.012), (13, -0.006), (25, -0.012), (37, 0.006), (49, 0.012)):
        ring.location.z = geometry.DEPTH + height
        ring.keyframe_insert("location", index=2, frame=frame)
    return [geometry.add_coping([stone]), geometry.add_deck([deck]), ring]


def add_probe():
    """Make the probe that EEVEE looks up where a refracted ray leaves the screen."""
    data = bpy.data.lightprobes.new("Pool Probe", "SPHERE")
    data.influence_type = data.parallax_type = "BOX"
    data.use_custom_parallax = True
    data.influence_distance, data.parallax_distance = geometry.HALF + 0.6, geometry.HALF
    data.falloff, data.clip_start = 0.05, 0.05
    probe = tools.add_object("Pool Probe", data)
    probe.location.z = geometry.DEPTH / 2
    probe.scale.z = geometry.DEPTH / 2 / geometry.HALF
    return probe


def main():
    """Build the scene and save it."""
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    group = tile_coordinates()
    receivers = add_receivers(group)
    water = add_water()
    tools.add_collection("Surroundings", *add_surroundings(group))
    tools.add_sun(SUN, 3.5, 0.53)
    tools.set_sky((0.62, 0.72, 0.80), (0.16, 0.34, 0.68), 0.35)
    add_probe()
    tools.choose(water, receivers)
    scene.camera = tools.add_camera("Edge", (1.5, -2.85, 3.5), (-0.32, 0.22, 0.5), 28.0)
    tools.add_camera("Underwater", (1.75, -1.75, 0.95), (-0.9, 0.9, 0.72), 20.0)
    tools.save("pool.blend")


if __name__ == "__main__":
    main()
