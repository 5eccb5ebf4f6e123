"""The pool's meshes, and the charts that unwrap them: every receiver has one scale, and its charts never touch.

A chart is made of quads (corners (4,3) [m], flat (4,2) [m], material index): counter-clockwise seen from inside the
pool, and placed on a square sheet measured in metres, which `add_receiver` shrinks to the unit square.
"""

from __future__ import annotations

import numpy as np
import scene_tools as tools

HALF, DEPTH, TOP = 2.0, 1.5, 1.7
WATERLINE = 1.3
TREAD, RISE, STEP_WIDTH, NOSE = 0.3, 0.3, 2.0, 0.05
STEPS = 4
# Between charts, as part of the sheet: ten texels of a lightmap of 512.
GAP = 10 / 512
SIDES = ((-1, 0), (0, 1), (1, 0), (0, -1))


def quad(origin, u, v, flat, flat_u, flat_v, material=0):
    """Return a quad spanned by u and v from `origin`, and its image spanned by flat_u and flat_v from `flat`."""
    spans = ((0, 0), (1, 0), (1, 1), (0, 1))
    corners = [np.add(origin, np.multiply(u, a) + np.multiply(v, b)) for a, b in spans]
    image = [np.add(flat, np.multiply(flat_u, a) + np.multiply(flat_v, b)) for a, b in spans]
    return np.array(corners, float), np.array(image, float), material


def floor():
    """Return the floor's quad, which fills the sheet with u along x and v along y, and the sheet's side [m]."""
    side = 2 * HALF
    return [quad((-HALF, -HALF, 0), (side, 0, 0), (0, side, 0), (0, 0), (side, 0), (0, side))], side


def walls():
    """Return four walls, set on the sheet like the sails of a windmill to waste little, and the sheet's side [m]."""
    length, quads = 2 * HALF, []
    side = (length + TOP) / (1 - 2 * GAP)
    rim = side * GAP / 2
    for x, y in SIDES:
        along, right = np.array([x, y, 0]) * length, np.array([-x, y]) * length
        start = np.array([-x - y, -y + x, 0]) * HALF
        up = np.array([-y, -x]) * 1.0
        place = side / 2 + (side / 2 - rim) * (-np.sign(right) - up)
        for low, high, material in ((0.0, WATERLINE, 0), (WATERLINE, TOP, 1)):
            height = high - low
            corner = start + np.array([0, 0, low])
            quads.append(quad(corner, along, (0, 0, height), place + up * low, right, up * height, material))
    return quads, side


def steps():
    """Return the steps in the corner at -x, +y: treads and risers unrolled, their flank beside; and the side [m]."""
    side = (STEP_WIDTH + STEPS * TREAD) / (1 - 2 * GAP)
    rim = side * GAP / 2
    quads, place, down = [], np.array([-HALF, HALF, STEPS * RISE]), 0.0
    profile = ((TREAD - NOSE, 0, 0), (NOSE, 0, 1), (0, -RISE, 0)) * STEPS
    for forward, drop, material in profile:
        length = forward - drop
        flat = (rim, rim + down)
        quads.append(quad(place, (0, -STEP_WIDTH, 0), (forward, 0, drop), flat, (STEP_WIDTH, 0), (0, length), material))
        place, down = np.add(place, (forward, 0, drop)), down + length
    for step in range(STEPS):
        corner, flat = (-HALF + step * TREAD, HALF - STEP_WIDTH, 0), (3 * rim + STEP_WIDTH + step * TREAD, rim)
        height = (STEPS - step) * RISE
        quads.append(quad(corner, (TREAD, 0, 0), (0, 0, height), flat, (TREAD, 0), (0, height)))
    return quads, side


def add_receiver(name, sheet, materials):
    """Make the mesh object of a sheet, (quads, side [m]), with its UV map "Lightmap"; quads share no vertices."""
    quads, side = sheet
    positions = np.concatenate([corners for corners, _, _ in quads])
    obj = tools.add_mesh(name, positions, np.arange(len(positions)).reshape(-1, 4), materials)
    tools.add_uvs(obj.data, np.concatenate([flat for _, flat, _ in quads]) / side)
    obj.data.polygons.foreach_set("material_index", [material for _, _, material in quads])
    return obj


def _square(half, height):
    """Return the corners (4,3) of a horizontal square about the axis."""
    return [(x * half, y * half, height) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def _bands(rings):
    """Return the quads between consecutive rings of four corners, from the inner one outwards seen from above."""
    faces = []
    for ring in range(rings - 1):
        for i in range(4):
            j = (i + 1) % 4
            faces.append((4 * ring + i, 4 * ring + 4 + i, 4 * ring + 4 + j, 4 * ring + j))
    return faces


def add_coping(materials):
    """Make the stones round the rim, which overhang it by 3 cm and hide the water's own rim from the sun."""
    inner, outer, low, high = 1.97, 2.40, TOP, TOP + 0.06
    rings = (_square(outer, low), _square(inner, low), _square(inner, high), _square(outer, high), _square(outer, low))
    coping = tools.add_mesh("Coping", np.concatenate(rings), _bands(len(rings)), materials)
    bevel = coping.modifiers.new("Rounded", "BEVEL")
    bevel.width, bevel.segments = 0.012, 3
    return coping


def add_deck(materials):
    """Make the paving from under the coping's edge to 9 m away."""
    return tools.add_mesh("Deck", _square(2.38, TOP + 0.05) + _square(9.0, TOP + 0.05), _bands(2), materials)


def add_ring(materials, major=0.42, minor=0.11, around=72, across=24):
    """Make the floating ring, radii in metres, in eight stripes of two materials, half under water."""
    a, b = np.meshgrid(*(np.arange(n) * 2 * np.pi / n for n in (around, across)), indexing="ij")
    radius = major + minor * np.cos(b)
    positions = np.stack([radius * np.cos(a), radius * np.sin(a), minor * np.sin(b)], axis=-1).reshape(-1, 3)
    ring = tools.add_mesh("Ring", positions, tools.torus_faces(around, across), materials, smooth=True)
    stripe = np.arange(around * across) // across * 8 // around
    ring.data.polygons.foreach_set("material_index", stripe % 2)
    ring.location = (0.75, -0.1, DEPTH)
    return ring
