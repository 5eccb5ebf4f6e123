"""Suns, exposure and lamps that are left out, against closed forms."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

from dapple.tests.blender.read_things import add, floor_and_sun, grid, read, sun


@pytest.fixture
def pool(empty_scene):
    return floor_and_sun(empty_scene)


def test_sun_direction_and_strength(pool):
    grid("Water", z=1.0)
    lamp = bpy.data.objects["Sun"]
    lamp.rotation_euler = Vector((-0.25, -0.1, 1.0)).to_track_quat("Z", "Y").to_euler()
    lamp.scale = (3, 3, 3)
    lamp.data.energy, lamp.data.color, lamp.data.angle = 3.0, (1.0, 0.5, 0.25), math.radians(0.53)
    (found,) = read()[0].lights
    np.testing.assert_allclose(found.direction, np.array([0.25, 0.1, -1]) / math.sqrt(1.0725), atol=1e-6)
    np.testing.assert_allclose(found.irradiance, (3.0, 1.5, 0.75))
    assert found.angle == pytest.approx(math.radians(0.53))


@pytest.mark.skipif("exposure" not in bpy.types.SunLight.bl_rna.properties, reason="lamps have it since Blender 4.5")
def test_exposure_temperature_and_radiance(pool):
    grid("Water", z=1.0)
    light = bpy.data.lights["Sun"]
    light.exposure, light.use_temperature, light.temperature = 1.0, True, 4000.0
    light.normalize, light.angle = False, 0.5
    (found,) = read()[0].lights
    # Cycles 5.0 renders a white floor under this lamp, white, at 0.19225 W/m^2
    np.testing.assert_allclose(found.irradiance, 2 * 0.192248 * np.array(light.temperature_color), rtol=1e-3)


def test_lamps_that_are_left_out_are_named(pool):
    grid("Water", z=1.0)
    add("Panel", bpy.data.lights.new("Panel", "AREA")).scale.y = 0.0
    add("Sunken", bpy.data.lights.new("Sunken", "POINT")).location.z = 0.5
    upward = sun(rotation=(math.pi, 0, 0))
    unlit = sun(energy=0.0)
    scene, warnings = read()
    assert [s.name for s in scene.lights] == ["Sun"]
    assert any("'Panel' has no area and was left out: set its size" in w for w in warnings)
    assert any("'Sunken' is under the water" in w for w in warnings)
    assert any(f"'{upward.name}' shines upward" in w for w in warnings)
    assert not any(unlit.name in w for w in warnings)
