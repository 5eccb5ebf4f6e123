"""Build mirror_room.blend: a glass ball, a brass star and a mirror in a corner of a room, under a swaying lamp.

Run as `python sample_blends/build_mirror_room.py` with bpy 4.2 or later; the committed file is written by 4.2. Lamp,
camera and both objects move: the ball hops, the star turns. The mirror throws the lamp's light back into the room, and
shows the caustics on floor and walls as it shows all else: they are in the maps. There is no water.
"""

from __future__ import annotations

import bpy
import numpy as np
import pool_geometry as geometry
import scene_tools as tools
from mathutils import Vector

HALF, HEIGHT = 1.6, 2.2  # of the floor and of the walls [m]
MIRROR = (-0.95, 0.85, 0.30, 1.75)  # of the wall at -x: from y, to y, from z, to z [m]
WIDTH = 0.05  # of the mirror's frame [m]
LAMP = (0.90, -0.75, 1.9)
GAP = 0.002


def add_receivers():
    """Make the floor, and the two walls of the corner side by side on one sheet."""
    side, rim = 2 * HALF, 0.04
    floor = [geometry.quad((-HALF, -HALF, 0), (side, 0, 0), (0, side, 0), (0, 0), (side, 0), (0, side))]
    sheet = 2 * HEIGHT + 3 * rim
    back = geometry.quad((-HALF, HALF, 0), (side, 0, 0), (0, 0, HEIGHT), (rim, rim), (side, 0), (0, HEIGHT))
    left = geometry.quad(
        (-HALF, -HALF, 0), (0, side, 0), (0, 0, HEIGHT), (rim, 2 * rim + HEIGHT), (side, 0), (0, HEIGHT)
    )
    stone, plaster = new_stone(), tools.new_plain("Plaster", (0.62, 0.58, 0.52), 0.9, 0.0)
    return [
        geometry.add_receiver("Floor", (floor, side), [stone]),
        geometry.add_receiver("Walls", ([back, left], sheet), [plaster]),
    ]


def new_stone():
    """Make pale stone slabs, 40 cm wide."""
    material, shader = tools.new_material("Stone")
    tree = material.node_tree
    place = tools.add_node(tree, "ShaderNodeTexCoord").outputs["Object"]
    bricks = {"Vector": place, "Scale": 1.0, "Mortar Size": 0.002, "Brick Width": 0.4, "Row Height": 0.4}
    bricks |= {"Color1": (0.44, 0.42, 0.39, 1), "Color2": (0.37, 0.36, 0.34, 1), "Mortar": (0.12, 0.11, 0.10, 1)}
    pattern = tools.add_node(tree, "ShaderNodeTexBrick", bricks, offset=0.0, squash=1.0)
    tree.links.new(pattern.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.8
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def add_mirror(material, wood):
    """Make the mirror, 3 cm before the wall, its frame, and the probe by which EEVEE mirrors what is off the screen."""
    y0, y1, z0, z1 = MIRROR
    x = 0.03 - HALF
    corners = [(x, y0, z0), (x, y1, z0), (x, y1, z1), (x, y0, z1)]
    mirror = tools.add_mesh("Mirror", corners, [(0, 1, 2, 3)], [material])
    a, b, c, d = y0 - WIDTH, y1 + WIDTH, z0 - WIDTH, z1 + WIDTH
    outer = [(x, a, c), (x, b, c), (x, b, d), (x, a, d)]
    ring = [(k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k) for k in range(4)]
    frame = tools.add_mesh("Frame", outer + corners, ring, [wood])
    solid = frame.modifiers.new("Thick", "SOLIDIFY")
    solid.thickness, solid.offset = 0.03, 0.0
    data = bpy.data.lightprobes.new("Mirror Probe", "PLANE")
    data.influence_distance = 0.05
    probe = tools.add_object("Mirror Probe", data)
    probe.location = (x + 0.001, (y0 + y1) / 2, (z0 + z1) / 2)
    probe.rotation_euler = (0.0, np.pi / 2, 0.0)
    probe.scale = ((z1 - z0) / 2, (y1 - y0) / 2, 1.0)
    return mirror, frame


def add_ball(material):
    """Make the glass ball, which hops twice in the 48 frames."""
    radius = 0.24
    positions, faces = tools.ball(radius, 96, 48)
    ball = tools.add_mesh("Ball", positions, faces, [material], smooth=True)
    ball.location = (-0.35, 0.45, radius + GAP)
    for frame, height in ((1, 0.0), (13, 0.30), (25, 0.0), (37, 0.30), (49, 0.0)):
        ball.location.z = radius + GAP + height
        ball.keyframe_insert("location", index=2, frame=frame)
    return ball


def add_star(material):
    """Make the brass star, a band whose radius waves five times; a fifth of a turn brings it back to itself."""
    around, thickness, height = 240, 0.008, 0.13
    angle = np.arange(around) * 2 * np.pi / around
    radius = 0.30 * (1.0 + 0.16 * np.cos(5 * angle))
    profile = ((-thickness, 0.0), (thickness, 0.0), (thickness, height), (-thickness, height))
    rings = [np.stack([(radius + r) * np.cos(angle), (radius + r) * np.sin(angle), 0 * angle + z]) for r, z in profile]
    positions = np.stack(rings).transpose(2, 0, 1).reshape(-1, 3)
    star = tools.add_mesh("Star", positions, tools.torus_faces(around, len(profile)), [material], smooth=True)
    edges = star.modifiers.new("Sharp Edges", "EDGE_SPLIT")
    edges.split_angle = np.radians(40.0)
    star.location = (0.20, -0.25, GAP)
    for frame, turn in ((1, 0.0), (tools.FRAMES + 1, 2 * np.pi / 5)):
        star.rotation_euler.z = turn
        star.keyframe_insert("rotation_euler", index=2, frame=frame)
    tools.move_evenly(star)
    return star


def add_lamp():
    """Make the spot lamp, which sways; its shade is not modelled."""
    data = bpy.data.lights.new("Lamp", "SPOT")
    data.energy, data.spot_size, data.spot_blend = 330.0, np.radians(92.0), 0.3
    data.color, data.shadow_soft_size = (1.0, 0.90, 0.76), 0.008
    data.cycles.is_caustics_light = True
    lamp = tools.add_object("Lamp", data)
    lamp.location = LAMP
    lamp.rotation_euler = Vector((-1.1, 0.95, -1.9)).to_track_quat("-Z", "Y").to_euler()
    for frame, sway in ((1, 0.0), (13, 0.3), (25, 0.0), (37, -0.3), (49, 0.0)):
        lamp.location.y = LAMP[1] + sway
        lamp.keyframe_insert("location", index=1, frame=frame)
    return lamp


def add_probe():
    """Make the probe that EEVEE looks up in the mirror's picture, where it traces no rays."""
    data = bpy.data.lightprobes.new("Room Probe", "SPHERE")
    data.influence_type, data.influence_distance = "BOX", HALF
    data.falloff, data.clip_start = 0.05, 0.05
    probe = tools.add_object("Room Probe", data)
    probe.location = (0.0, 0.0, 0.9)


def add_cameras(scene):
    """Make the camera that drifts along the room, and the one that looks into the mirror."""
    room = tools.add_camera("Room", (1.75, -2.25, 1.65), (-0.50, 0.30, 0.45), 26.0)
    for frame, drift in ((1, 0.0), (25, 0.25), (49, 0.0)):
        room.location.x = 1.75 + drift
        room.keyframe_insert("location", index=0, frame=frame)
    tools.add_camera("Into the Mirror", (0.95, -1.75, 1.35), (-1.57, -0.42, 0.62), 42.0)
    scene.camera = room


def main():
    """Build the scene and save it."""
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    receivers = add_receivers()
    silver = tools.new_metal("Silver", (0.94, 0.95, 0.94))
    mirror, _ = add_mirror(silver, tools.new_plain("Dark Wood", (0.09, 0.05, 0.03), 0.5))
    ball = add_ball(tools.new_glass("Amber Glass", 1.5, (0.95, 0.66, 0.30)))
    star = add_star(tools.new_metal("Brass", (0.91, 0.74, 0.40)))
    add_lamp()
    add_probe()
    tools.set_sky((0.30, 0.34, 0.42), (0.20, 0.24, 0.32), 0.25)
    tools.choose(None, receivers, (mirror, ball, star))
    add_cameras(scene)
    tools.save("mirror_room.blend")


if __name__ == "__main__":
    main()
