"""Build glass.blend: a ball, a diamond, Suzanne and a gold ring on a table in the sun.

Run as `python sample_blends/build_glass.py` with bpy 4.2 or later; the committed file is written by 4.2. There is no
water: the objects cast by their materials. The diamond is a brilliant, cut from its facets' planes, and turns once in
the 48 frames. An Empty bounds the work; light that leaves it upwards ends there.
"""

from __future__ import annotations

import bpy
import numpy as np
import scene_tools as tools

TABLE, TOP = 1.5, 0.04  # [m]
SUN = (0.62, 0.35, -0.75)
GAP = 0.001  # between glass and table: at surfaces that touch, light would be in both

# Facets of a round brilliant, as (how many, turn in facets, angle from the girdle's plane in degrees, the point
# (radius, height) that the plane passes at its own azimuth), for a girdle of radius 1.
GIRDLE, TABLE_RADIUS = 0.02, 0.55
FACETS = (
    (8, 0.0, 34.5, (1.0, GIRDLE)),
    (16, 0.5, 40.5, (1.0, GIRDLE)),
    (8, 0.5, 22.0, (TABLE_RADIUS * 0.97, GIRDLE + (1.0 - TABLE_RADIUS) * np.tan(np.radians(34.5)))),
    (8, 0.0, -40.75, (1.0, -GIRDLE)),
    (16, 0.5, -42.3, (1.0, -GIRDLE)),
    (32, 0.5, 90.0, (1.0, 0.0)),
)


def facet_planes():
    """Return the planes of a brilliant: outward normals (P,3) and distances (P,) from its centre."""
    normals, distances = [np.array([[0.0, 0.0, 1.0]])], [np.array([FACETS[2][3][1]])]
    for count, turn, degrees, (radius, height) in FACETS:
        around = (np.arange(count) + turn) * 2 * np.pi / count
        tilt = np.radians(abs(degrees))
        up = np.sign(degrees) * np.cos(tilt)
        own = np.stack([np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around), np.full(count, up)], axis=-1)
        normals.append(own)
        distances.append(np.full(count, np.sin(tilt) * radius + up * height))
    return np.concatenate(normals), np.concatenate(distances)


def body_between(normals, distances):
    """Return the corners (V,3) and faces of the body that planes enclose: corners are the points of three planes that
    lie behind all others, faces go round those of one plane."""
    count = len(normals)
    i, j, k = np.array([(a, b, c) for a in range(count) for b in range(a) for c in range(b)]).T
    systems = np.stack([normals[i], normals[j], normals[k]], axis=1)
    right = np.stack([distances[i], distances[j], distances[k]], axis=1)
    meet = np.abs(np.linalg.det(systems)) > 1e-9
    points = np.linalg.solve(systems[meet], right[meet][..., None])[..., 0]
    corners = np.unique(points[(points @ normals.T <= distances + 1e-9).all(axis=1)].round(6), axis=0)
    faces = []
    for normal, distance in zip(normals, distances, strict=True):
        on = np.flatnonzero(np.abs(corners @ normal - distance) < 1e-5)
        if len(on) < 3:
            continue
        along = np.cross(normal, (0.3, 0.5, 0.8))
        spokes = corners[on] - corners[on].mean(axis=0)
        faces.append(on[np.argsort(np.arctan2(spokes @ np.cross(normal, along), spokes @ along))])
    return corners, faces


def add_diamond(radius, material):
    """Make the brilliant, lying on a facet of its pavilion as a loose stone does; its flat faces are its facets."""
    corners, faces = body_between(*facet_planes())
    diamond = tools.add_mesh("Diamond", corners * radius, faces, [material])
    # Turned about the plumb line first to last frame: the last Euler angle is the outermost.
    diamond.rotation_euler = (0.0, np.radians(40.75), 0.0)
    lowest = min((diamond.rotation_euler.to_matrix() @ vertex.co).z for vertex in diamond.data.vertices)
    diamond.location = (0.30, -0.16, GAP - lowest)
    for frame, turn in ((1, 0.0), (tools.FRAMES + 1, 2 * np.pi)):
        diamond.rotation_euler.z = turn
        diamond.keyframe_insert("rotation_euler", index=2, frame=frame)
    tools.move_evenly(diamond)
    return diamond


def add_ball(radius, material):
    """Make the glass ball."""
    positions, faces = tools.ball(radius, 96, 48)
    ball = tools.add_mesh("Ball", positions, faces, [material], smooth=True)
    ball.location = (-0.34, -0.24, radius + GAP)
    return ball


def add_ring(material):
    """Make the gold ring: a band, higher than it is thick, with rounded edges."""
    profile = np.array([(0.100, 0.0), (0.112, 0.004), (0.114, 0.03), (0.112, 0.056), (0.100, 0.06), (0.098, 0.03)])
    around, across = 160, len(profile)
    angle = np.arange(around) * 2 * np.pi / around
    radius, height = profile.T
    positions = np.stack(
        [np.outer(np.cos(angle), radius), np.outer(np.sin(angle), radius), np.tile(height, (around, 1))], axis=-1
    )
    ring = tools.add_mesh("Ring", positions.reshape(-1, 3), tools.torus_faces(around, across), [material], smooth=True)
    ring.modifiers.new("Rounded", "SUBSURF").levels = 2
    ring.location = (-0.02, -0.42, GAP)
    return ring


def add_suzanne(material):
    """Make Suzanne of one closed piece: her eyes are shells of their own, with open backs."""
    bpy.ops.mesh.primitive_monkey_add(size=0.36)
    suzanne = bpy.context.object
    suzanne.name = suzanne.data.name = "Suzanne"
    suzanne.modifiers.new("Subdivided", "SUBSURF").levels = 2
    closed = suzanne.modifiers.new("Closed", "REMESH")
    closed.mode, closed.voxel_size, closed.use_smooth_shade = "VOXEL", 0.006, True
    rounded = suzanne.modifiers.new("Rounded", "SMOOTH")
    rounded.factor, rounded.iterations = 0.5, 12
    suzanne.data.materials.append(material)
    suzanne.rotation_euler = (np.radians(-35.0), 0.0, np.radians(20.0))
    suzanne.location = (-0.02, 0.16, 0.0)
    bpy.context.view_layer.update()
    shown = suzanne.evaluated_get(bpy.context.evaluated_depsgraph_get())
    suzanne.location.z = GAP - min((suzanne.matrix_world @ vertex.co).z for vertex in shown.data.vertices)
    return suzanne


def add_table(material):
    """Make the table's top, which takes the light, and the slab below it."""
    half = TABLE / 2
    top = tools.add_mesh(
        "Table", [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [(0, 1, 2, 3)]
    )
    tools.add_uvs(top.data, [(0, 0), (1, 0), (1, 1), (0, 1)])
    top.data.materials.append(material)
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0, 0, -0.0005 - TOP / 2))
    slab = bpy.context.object
    slab.name, slab.scale = "Slab", (TABLE, TABLE, TOP)
    slab.data.materials.append(material)
    return top


def main():
    """Build the scene and save it."""
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    casters = [
        add_ball(0.15, tools.new_glass("Clear Glass", 1.5)),
        add_diamond(0.13, tools.new_glass("Diamond", 2.417)),
        add_suzanne(tools.new_glass("Green Glass", 1.5, (0.62, 0.92, 0.74))),
        add_ring(tools.new_metal("Gold", (1.0, 0.72, 0.30))),
    ]
    table = add_table(tools.new_speckled("Linen", 90.0, 4.0, (0.38, 0.35, 0.31), (0.46, 0.43, 0.38)))
    tools.add_sun(SUN, 4.0, 0.53)
    tools.set_sky((0.50, 0.55, 0.62), (0.30, 0.36, 0.46), 0.22)
    volume = tools.add_box("Caustics Volume", (0.0, -0.1, 0.19), (0.6, 0.6, 0.2))
    tools.choose(None, [table], casters)
    scene.dapple.volume, scene.dapple.culling = volume, {"+Z"}
    scene.camera = tools.add_camera("Above", (0.30, -1.30, 0.88), (0.04, -0.12, 0.05), 38.0)
    tools.add_camera("Near", (0.42, -0.95, 0.40), (-0.14, -0.18, 0.03), 40.0)
    tools.save("glass.blend")


if __name__ == "__main__":
    main()
