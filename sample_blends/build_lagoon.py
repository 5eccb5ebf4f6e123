"""Build lagoon.blend: a boat and three fish over an uneven bed, under five travelling sines.

Run as `python sample_blends/build_lagoon.py` with bpy 4.2 or later; the committed file is written by 4.2. The sun is
low: what the water lets through dances on the bed and on the fish, what it mirrors on the side of the hull. The waves
are those of build_pool.py with other numbers; the water's mean level is z = 0, and the 48 frames loop.
"""

from __future__ import annotations

import build_pool as pool
import numpy as np
import scene_tools as tools

# amplitude [m], wavelength [m], direction [degrees], phase [rad]
WAVES = (
    (0.016, 1.90, 65.0, 0.0),
    (0.010, 1.10, 110.0, 1.1),
    (0.007, 0.70, 35.0, 2.3),
    (0.004, 0.41, 150.0, 0.4),
    (0.0025, 0.27, -80.0, 3.0),
)
SUN = (0.20, 0.80, -0.62)
BED_SIZE, BED_CELLS = 10.0, 128
WATER_SIZE, WATER_CELLS = 11.0, 192
ROCKS = ((-1.9, -0.6, 0.55, 0.42), (-1.3, -1.0, 0.35, 0.28), (2.3, -0.2, 0.60, 0.45), (0.6, -2.2, 0.40, 0.25))
# length [m], x, y, z [m], heading [degrees]
FISH = ((0.62, -0.75, -1.05, -0.32, 12.0), (0.48, 0.25, -1.45, -0.26, -8.0), (0.55, 1.25, -0.85, -0.42, 20.0))


def bed_height(x, y):
    """Return the height [m] of the bed: a slope, dunes, ripples, and rocks."""
    height = -1.15 - 0.10 * y + 0.10 * np.sin(0.9 * x + 0.4 * y) + 0.05 * np.sin(1.9 * y - 0.7 * x)
    height = height + 0.008 * np.sin(11.0 * (y + 0.3 * x) + 1.1 * np.sin(1.7 * x))
    for rx, ry, radius, top in ROCKS:
        angle = np.arctan2(y - ry, x - rx)
        outline = radius * (1.0 + 0.12 * np.sin(3.0 * angle + rx) + 0.05 * np.sin(7.0 * angle))
        inside = np.clip(1.0 - ((x - rx) ** 2 + (y - ry) ** 2) / outline**2, 0.0, None)
        height = height + top * inside**0.6
    return height


def add_tube(name, rings, materials, margin=0.02):
    """Make a smooth receiver from closed rings (R,N,3) [m], counter-clockwise seen from the last one, with UVs along
    and around it; its two ends stay open."""
    count, around, _ = rings.shape
    i, j = (index.ravel() for index in np.indices((count - 1, around)))
    after = (j + 1) % around
    faces = np.stack([i * around + j, i * around + after, (i + 1) * around + after, (i + 1) * around + j], axis=-1)
    obj = tools.add_mesh(name, rings.reshape(-1, 3), faces, materials, smooth=True)
    across, along = (
        np.stack([j, j + 1, j + 1, j], axis=-1) / around,
        np.stack([i, i, i + 1, i + 1], axis=-1) / (count - 1),
    )
    tools.add_uvs(obj.data, (margin + (1 - 2 * margin) * np.stack([across, along], axis=-1)).reshape(-1, 2))
    return obj


def fish_rings(length):
    """Return the rings (R,N,3) [m] of a fish along x, nose first: an ellipse that flattens into a tail fin."""
    stations = np.linspace(0.0, 1.0, 41)
    body = np.sqrt(np.clip(stations, 0, 1)) * (1 - stations) ** 0.8
    tail = 0.22 * np.exp(-(((stations - 1.0) / 0.11) ** 2))
    high = length * np.maximum(0.36 * body + 0.9 * tail, 0.004)
    wide = length * np.maximum(0.22 * body, 0.004)
    angle = np.arange(32) * 2 * np.pi / 32
    x = np.broadcast_to(length * (0.5 - stations)[:, None], (41, 32))
    return np.stack([x, -wide[:, None] * np.cos(angle), high[:, None] * np.sin(angle)], axis=-1)


def add_fish():
    """Make the fish, each on a small round that the 48 frames close."""
    scales = (
        tools.new_plain("Orange Scales", (0.85, 0.32, 0.07), 0.6, 0.0),
        tools.new_plain("White Scales", (0.78, 0.76, 0.70), 0.6, 0.0),
        tools.new_plain("Blue Scales", (0.16, 0.36, 0.62), 0.6, 0.0),
    )
    made = []
    for number, (length, x, y, z, heading) in enumerate(FISH, 1):
        fish = add_tube(f"Fish {number}", fish_rings(length), [scales[number - 1]])
        for frame in range(1, tools.FRAMES + 2, 6):
            turn = 2 * np.pi * (frame - 1) / tools.FRAMES + number
            fish.location = (x + 0.06 * np.cos(turn), y + 0.03 * np.sin(turn), z + 0.02 * np.sin(turn))
            fish.rotation_euler.z = np.radians(heading + 6.0 * np.sin(turn))
            fish.keyframe_insert("location", frame=frame)
            fish.keyframe_insert("rotation_euler", index=2, frame=frame)
        made.append(fish)
    return made


def hull_sections():
    """Return the open sections (R,N,3) [m] of a hull along x, from the gunwale at -y under the keel to that at +y."""
    station = np.linspace(-1.0, 1.0, 49)[:, None]
    around = np.linspace(-np.pi / 2, np.pi / 2, 33)
    half = np.maximum(0.58 * (1 - np.abs(station) ** 2.6), 0.004)
    top, keel = 0.42 + 0.20 * station**2, -0.22 + 0.34 * np.abs(station) ** 3
    down = np.cos(around) ** 0.7
    x = 1.55 * station * (1 + 0.06 * (1 - down))
    return np.stack([x + 0 * around, half * np.sin(around) * (1 - 0.1 * down), top - (top - keel) * down], axis=-1)


def add_hull(sections):
    """Make the hull, which takes light, from sections (R,N,3) [m]: white, red below the water line."""
    count, around, _ = sections.shape
    i, j = (index.ravel() for index in np.indices((count - 1, around - 1)))
    along, across = np.stack([i, i, i + 1, i + 1], axis=-1), np.stack([j, j + 1, j + 1, j], axis=-1)
    paints = (("White Paint", (0.80, 0.79, 0.76)), ("Red Paint", (0.5, 0.05, 0.04)))
    materials = [tools.new_plain(name, colour, 0.5, 0.0) for name, colour in paints]
    hull = tools.add_mesh("Hull", sections.reshape(-1, 3), along * around + across, materials, smooth=True)
    below = np.abs(j + 0.5 - (around - 1) / 2) < 0.22 * around
    hull.data.polygons.foreach_set("material_index", below.astype(int))
    flat = np.stack([across / (around - 1), along / (count - 1)], axis=-1)
    tools.add_uvs(hull.data, (0.02 + 0.96 * flat).reshape(-1, 2))
    return hull


def add_boat():
    """Make the boat, which rocks: its hull, and its deck, which only blocks light."""
    sections = hull_sections()
    hull = add_hull(sections)
    rim = np.concatenate([sections[:, :1], sections[:, -1:]], axis=1) - (0.0, 0.0, 0.03)
    k = 2 * np.arange(len(sections) - 1)
    planks = tools.new_plain("Planks", (0.45, 0.28, 0.14), 0.6, 0.1)
    deck = tools.add_mesh("Deck", rim.reshape(-1, 3), np.stack([k, k + 2, k + 3, k + 1], axis=-1), [planks])
    deck.parent = hull
    hull.location = (0.15, 1.05, 0.0)
    hull.rotation_euler.z = np.radians(-8.0)
    for frame, roll in ((1, 1.2), (25, -1.2), (49, 1.2)):
        hull.rotation_euler.x = np.radians(roll)
        hull.keyframe_insert("rotation_euler", index=0, frame=frame)
    return hull


def add_water():
    """Make the water, clear, with the sines."""
    water = tools.add_grid("Water", WATER_SIZE, WATER_CELLS, lambda x, _: 0.0 * x, [tools.new_water()])
    water.modifiers.new("Waves", "NODES").node_group = pool.wave_nodes(WAVES)
    return water


def add_bed():
    """Make the bed, with a UV map that is its plan."""
    sand = tools.new_speckled("Sand", 5.0, 6.0, (0.40, 0.40, 0.30), (0.62, 0.60, 0.46))
    bed = tools.add_grid("Bed", BED_SIZE, BED_CELLS, bed_height, [sand])
    corners = np.empty(len(bed.data.loops), np.int32)
    bed.data.loops.foreach_get("vertex_index", corners)
    plan = np.array([vertex.co[:2] for vertex in bed.data.vertices])
    tools.add_uvs(bed.data, plan[corners] / BED_SIZE + 0.5)
    return bed


def main():
    """Build the scene and save it."""
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    receivers = [add_bed(), add_boat(), *add_fish()]
    water = add_water()
    tools.add_sun(SUN, 3.5, 0.53)
    tools.set_sky((0.16, 0.38, 0.44), (0.16, 0.36, 0.66), 0.5)
    tools.choose(water, receivers)
    scene.camera = tools.add_camera("Boat", (-0.9, -3.0, 2.1), (0.22, 0.10, -0.35), 28.0)
    tools.add_camera("Diver", (-1.9, -2.3, -0.55), (0.4, -0.4, -0.45), 24.0)
    tools.save("lagoon.blend")


if __name__ == "__main__":
    main()
