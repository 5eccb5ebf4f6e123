"""Build calm_pond.blend: a square garden pond on a still evening, its water hardly moved.

Run as `python sample_blends/build_calm_pond.py` with bpy 4.2 or later; the committed file is written by 4.2. The pond
is 3 x 3 x 0.6 m; its bed lies about z = 0. The water is moved as that of the pool is, by sines so low for the depth
that no two paths of light lead to one place: the light on the bed varies by some 7 %.
"""

from __future__ import annotations

import numpy as np
import scene_tools as tools
from build_pool import wave_nodes

HALF, DEPTH, RIM, THICK = 1.5, 0.6, 0.05, 0.25
BED_CELLS = 64
WATER_SIZE, WATER_CELLS = 3.2, 96
# amplitude [m], wavelength [m], direction [degrees], phase [rad]
WAVES = (
    (0.0036, 1.40, 15.0, 0.3),
    (0.0022, 0.80, 70.0, 1.9),
    (0.0017, 0.50, -35.0, 2.6),
    (0.0011, 0.33, 110.0, 0.8),
)
SUN = (0.45, 0.25, -1.0)


def bed_height(x, y):
    """Return the height [m] of the bed: sand that the feet of birds have left uneven."""
    return 0.012 * np.sin(2.3 * x + 0.9 * y) + 0.008 * np.sin(4.1 * y - 1.7 * x) + 0.004 * np.sin(9.0 * x + 7.0 * y)


def add_bed():
    """Make the bed, whose UV map is its plan."""
    sand = tools.new_speckled("Sand", 40.0, 4.0, (0.36, 0.30, 0.20), (0.62, 0.54, 0.40))
    bed = tools.add_grid("Bed", 2 * HALF, BED_CELLS, bed_height, [sand])
    corners = np.empty(len(bed.data.loops), np.int32)
    bed.data.loops.foreach_get("vertex_index", corners)
    places = np.empty(3 * len(bed.data.vertices), np.float32)
    bed.data.vertices.foreach_get("co", places)
    tools.add_uvs(bed.data, places.reshape(-1, 3)[corners, :2] / (2 * HALF) + 0.5)
    return bed


def add_water():
    """Make the water: a grid that reaches 0.1 m into the walls."""
    water = tools.add_grid("Water", WATER_SIZE, WATER_CELLS, lambda x, _: 0.0 * x, [tools.new_water()])
    water.location.z = DEPTH
    water.modifiers.new("Waves", "NODES").node_group = wave_nodes(WAVES)
    return water


def add_surroundings():
    """Make the walls, one frame of stone about the bed, and the lawn."""
    inner, outer, low, high = HALF, HALF + THICK, -0.1, DEPTH + RIM
    turns = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    rings = [(inner, low), (inner, high), (outer, high), (outer, low)]
    places = [(x * reach, y * reach, z) for reach, z in rings for x, y in turns]
    faces = []
    for ring in range(3):
        for k in range(4):
            a, b = 4 * ring + k, 4 * ring + (k + 1) % 4
            faces.append((a, a + 4, b + 4, b))
    stone = tools.new_speckled("Stone", 9.0, 5.0, (0.30, 0.29, 0.27), (0.52, 0.50, 0.46))
    walls = tools.add_mesh("Walls", places, faces, [stone])
    grass = tools.new_speckled("Lawn", 60.0, 6.0, (0.05, 0.12, 0.02), (0.14, 0.26, 0.05))
    reach = 6.0
    hole = [(x * outer, y * outer, DEPTH) for x, y in turns]
    far = [(x * reach, y * reach, DEPTH) for x, y in turns]
    lawn = tools.add_mesh("Lawn", hole + far, [(k, k + 4, (k + 1) % 4 + 4, (k + 1) % 4) for k in range(4)], [grass])
    return [walls, lawn]


def main():
    """Build the scene and save it."""
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    bed, water = add_bed(), add_water()
    tools.add_collection("Surroundings", *add_surroundings())
    tools.add_sun(SUN, 3.5, 0.53)
    tools.set_sky((0.62, 0.70, 0.74), (0.20, 0.36, 0.62), 0.35)
    tools.choose(water, [bed])
    scene.camera = tools.add_camera("Bench", (0.6, -3.4, 2.6), (0.0, 0.0, 0.3), 35.0)
    tools.save("calm_pond.blend")


if __name__ == "__main__":
    main()
