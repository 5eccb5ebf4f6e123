"""Build ocean.blend: Blender's Ocean modifier over a sandy bed with dunes and boulders.

Run as `python sample_blends/build_ocean.py` with bpy 4.2 or later, built with the ocean simulation; the committed file
is written by 4.2. The waves are spectral, their normals Blender's own, and nothing is known in closed form: this is
the scene of an artist, where the pool is that of a test. Depth 1.1 to 1.9 m, bed 10 x 10 m, water 12 x 12 m.
"""

from __future__ import annotations

import bpy
import numpy as np
import scene_tools as tools

BED_SIZE, BED_CELLS = 10.0, 128
WATER_SIZE, WATER_CELLS = 12.0, 192
# x, y, radius, height [m]
BOULDERS = (
    (-1.6, 0.9, 0.75, 0.60),
    (-0.8, 1.5, 0.45, 0.32),
    (1.9, 1.3, 0.60, 0.45),
    (2.6, -0.6, 0.35, 0.22),
    (-2.9, -1.2, 0.50, 0.36),
    (0.5, 3.1, 0.90, 0.70),
)
DEPTH = 1.7
SUN = (0.35, 0.45, -1.0)


def sand_height(x, y):
    """Return the height [m] of the sand under the water's mean level: a slope, dunes and ripples."""
    slope = 0.035 * y
    dunes = 0.09 * np.sin(0.9 * x + 0.5 * y + 0.6 * np.sin(0.7 * y)) + 0.05 * np.sin(1.7 * y - 0.8 * x)
    ripples = 0.008 * np.sin(9.0 * (y + 0.25 * x) + 1.2 * np.sin(1.3 * x))
    return slope + dunes + ripples - DEPTH


def rock_height(x, y):
    """Return the height [m] of the boulders over the sand, 0 where there is none."""
    height = np.zeros_like(x)
    for bx, by, radius, top in BOULDERS:
        angle = np.arctan2(y - by, x - bx)
        outline = radius * (1.0 + 0.12 * np.sin(3.0 * angle + bx) + 0.06 * np.sin(5.0 * angle + by))
        inside = np.clip(1.0 - ((x - bx) ** 2 + (y - by) ** 2) / outline**2, 0.0, None)
        ridges = (
            0.10 * np.sin(7.1 * x + 3.0 * y) + 0.07 * np.sin(11.3 * y - 5.2 * x) + 0.04 * np.sin(19.0 * x + 13.0 * y)
        )
        height = np.maximum(height, top * inside**0.55 * (1.0 + ridges))
    return height


def bed_height(x, y):
    """Return the height [m] of the bed."""
    return sand_height(x, y) + rock_height(x, y)


def sand_and_rock():
    """Make pale sand and, where the point attribute "rock" is 1, dark mottled stone."""
    material, shader = tools.new_material("Sand and Rock")
    tree = material.node_tree
    rock = tools.add_node(tree, "ShaderNodeAttribute", attribute_name="rock").outputs["Fac"]
    place = tools.add_node(tree, "ShaderNodeTexCoord").outputs["Object"]
    noise = tools.add_node(tree, "ShaderNodeTexNoise", {"Vector": place, "Scale": 6.0, "Detail": 5.0}).outputs[0]
    ramps = []
    for dark, light in (((0.44, 0.37, 0.25), (0.60, 0.52, 0.37)), ((0.06, 0.08, 0.06), (0.24, 0.22, 0.17))):
        ramp = tools.add_node(tree, "ShaderNodeValToRGB", {"Fac": noise})
        for stop, position, colour in zip(ramp.color_ramp.elements, (0.35, 0.65), (dark, light), strict=True):
            stop.position, stop.color = position, (*colour, 1.0)
        ramps.append(ramp.outputs["Color"])
    mix = tools.add_node(tree, "ShaderNodeMix", {0: rock}, data_type="RGBA")
    for ramp, socket in zip(ramps, (s for s in mix.inputs if s.type == "RGBA"), strict=True):
        tree.links.new(ramp, socket)
    tree.links.new(next(s for s in mix.outputs if s.type == "RGBA"), shader.inputs["Base Color"])
    shader.inputs["Roughness"].default_value = 0.8
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def add_bed():
    """Make the bed, a grid with a UV map that is its plan, mark its rock, and round it off by one subdivision."""
    bed = tools.add_grid("Bed", BED_SIZE, BED_CELLS, bed_height, [sand_and_rock()])
    corners = np.empty(len(bed.data.loops), np.int32)
    bed.data.loops.foreach_get("vertex_index", corners)
    positions = np.empty(3 * len(bed.data.vertices), np.float32)
    bed.data.vertices.foreach_get("co", positions)
    x, y, _ = positions.reshape(-1, 3).T
    tools.add_uvs(bed.data, np.stack([x, y], axis=-1)[corners] / BED_SIZE + 0.5)
    rock = bed.data.attributes.new("rock", "FLOAT", "POINT")
    rock.data.foreach_set("value", np.clip(rock_height(x, y) / 0.05, 0.0, 1.0).astype(np.float32))
    rounded = bed.modifiers.new("Rounded", "SUBSURF")
    rounded.levels = rounded.render_levels = 1
    rounded.uv_smooth = "NONE"
    return bed


def add_ocean():
    """Make the water: a flat grid that the Ocean modifier displaces, its clock driven by the frame."""
    water = tools.add_grid("Water", WATER_SIZE, WATER_CELLS, lambda x, _: 0.0 * x, [tools.new_water()])
    ocean = water.modifiers.new("Ocean", "OCEAN")
    ocean.geometry_mode = "DISPLACE"
    ocean.resolution = ocean.viewport_resolution = 12
    ocean.spatial_size = int(WATER_SIZE)
    ocean.depth = 20.0
    ocean.wind_velocity, ocean.wave_scale_min = 2.2, 0.02
    ocean.wave_scale, ocean.choppiness = 0.07, 0.6
    ocean.wave_alignment, ocean.wave_direction = 0.1, np.radians(35.0)
    ocean.random_seed = 7
    ocean.filepath = "//cache_ocean"  # else it names a folder of this machine
    ocean.driver_add("time").driver.expression = f"(frame - 1) / {tools.FPS}"
    return water


def main():
    """Build the scene and save it."""
    if not bpy.app.build_options.mod_oceansim:
        raise SystemExit("This Blender was built without the ocean simulation: use another one.")
    scene = tools.new_scene()
    scene.view_settings.look = "AgX - Medium High Contrast"
    bed, water = add_bed(), add_ocean()
    tools.add_sun(SUN, 3.5, 0.53)
    tools.set_sky((0.10, 0.30, 0.38), (0.12, 0.30, 0.60), 0.5)
    tools.choose(water, [bed])
    scene.camera = tools.add_camera("Diver", (1.2, -3.0, -0.60), (-0.5, 1.2, -1.35), 24.0)
    tools.add_camera("Above", (0.0, -4.6, 3.6), (0.0, 0.6, -1.2), 32.0)
    tools.save("ocean.blend")


if __name__ == "__main__":
    main()
