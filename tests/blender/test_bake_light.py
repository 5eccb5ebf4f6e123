"""The light that a bake writes, and what it says of it."""

import math
from dataclasses import replace

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import request_from_scene
from dapple.operators.errors import DappleError
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import (
    HALF,
    build_pool,
    record,
    run,
)
from dapple.tests.waves import transmitted


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


@pytest.mark.parametrize("method", ["photon_splat", "conic_walk"])
def test_flat_water_lets_through_what_fresnel_says(empty_scene, out, method):
    """Sun at 30 degrees: cos 30 (1 - F) = 0.8475 of its irradiance on a level floor, at any depth."""
    build_pool(empty_scene, out)
    empty_scene.dapple.method = method
    bpy.data.objects["Water"].scale = (3, 3, 1)
    bpy.data.objects["Sun"].rotation_euler = (math.radians(30), 0, 0)
    bpy.data.lights["Sun"].energy, bpy.data.lights["Sun"].color = 2.0, (1.0, 0.5, 0.0)
    run(empty_scene, frames=(4,))
    image = read_exr(out / "Floor/caustics_0004.exr")
    np.testing.assert_allclose(image.mean((0, 1)), 2 * 0.8475 * np.array([1.0, 0.5, 0.0]), rtol=5e-3)
    assert ((image[..., 0] / (2 * 0.8475) - 1) ** 2).mean() < 2 * empty_scene.dapple.tolerance
    entry = record(out)["frames"]["4"]
    assert entry["method"] == method
    assert entry["flux_received"]["Floor"][0] == pytest.approx(4 * 2 * 0.8475, rel=5e-3)


def test_matching_cycles_is_a_smaller_map_and_no_fewer_watts(empty_scene, out):
    """Overhead sun over flat water: 0.9796 of its irradiance, over 1.333^2."""
    build_pool(empty_scene, out)
    bpy.data.objects["Water"].scale = (3, 3, 1)
    empty_scene.dapple.match_cycles = True
    run(empty_scene, frames=(1,))
    np.testing.assert_allclose(read_exr(out / "Floor/caustics_0001.exr"), 0.9796 / 1.333**2, rtol=1e-3)
    entry = record(out)["frames"]["1"]
    assert entry["map_scale"] == pytest.approx([1.333**-2] * 3)
    assert entry["flux_received"]["Floor"][0] == pytest.approx(4 * 0.9796, rel=1e-3)
    assert record(out)["settings"]["match_cycles"] is True


def test_water_that_lights_nothing_is_said(empty_scene, out):
    build_pool(empty_scene, out)
    bpy.data.objects["Water"].location.x = 10.0
    *_, last = run(empty_scene, frames=(1,))
    assert any(
        "No light by way of water, glass or mirrors reaches receiver 'Floor'" in warning for warning in last.warnings
    )
    assert any("No light by way of water" in warning for warning in record(out)["frames"]["1"]["warnings"])


def test_frames_in_which_nothing_moves_are_told_and_equal(empty_scene, out):
    build_pool(empty_scene, out)
    bpy.data.objects["Water"].animation_data_clear()
    run(empty_scene)
    first, second = (record(out)["frames"][n] for n in "12")
    assert second["same_as"] == 1 and "same_as" not in first
    assert first["flux_received"] == second["flux_received"]
    assert (out / "Floor/caustics_0001.exr").read_bytes() == (out / "Floor/caustics_0002.exr").read_bytes()


def test_reuse_keeps_its_share_from_frame_to_frame(pool, out):
    """The maps hold the water's height, 1, 1.1 and 1.2 m: the mean of each and what was kept before."""
    pool.dapple.reuse = 0.5
    run(pool)
    for n, kept in ((1, 1.0), (2, 1.05), (3, 1.125)):
        np.testing.assert_allclose(read_exr(out / f"Floor/caustics_{n:04d}.exr").astype(float), kept, rtol=HALF)
    assert any("trail" in sentence for sentence in record(out)["frames"]["3"]["left_out"])
    settings = replace(request_from_scene(pool).settings, reuse=1.0)
    with pytest.raises(DappleError, match="A reuse of 1 is out of range; set 0"):
        run(pool, settings=settings)


def test_light_that_falls_on_backs_is_said(empty_scene, out):
    build_pool(empty_scene, out)
    bpy.data.objects["Floor"].rotation_euler.x = math.pi
    *_, last = run(empty_scene, frames=(1,))
    assert not record(out)["frames"]["1"]["flux_received"]["Floor"][0]
    assert record(out)["frames"]["1"]["flux_lost"]["back"][0] > 1
    assert any("back" in warning and "Flip" in warning for warning in last.warnings)


def test_a_receiver_above_the_water_takes_what_is_reflected(empty_scene, out):
    build_pool(empty_scene, out)
    bpy.data.objects["Floor"].location.z, bpy.data.objects["Floor"].rotation_euler.x = 2.0, math.pi
    bpy.data.objects["Sun"].rotation_euler.y = -0.5  # light travels towards -x, and off the water still so
    *_, last = run(empty_scene, frames=(1,))
    frame = record(out)["frames"]["1"]
    # It shades what lies below it: light comes in past its edge only, over tan(0.5) m, on 2 m of still water.
    expected = 2 * math.sin(0.5) * (1 - transmitted(math.cos(0.5)))
    assert frame["flux_received"]["Floor"][0] == pytest.approx(expected, rel=0.01)
    assert not last.warnings


def test_a_lamp_whose_size_changes_is_baked_anew(pool, out):
    panel = bpy.data.objects.new("Panel", bpy.data.lights.new("Panel", "AREA"))
    panel.location.z, panel.data.energy = 3.0, 50.0
    pool.collection.objects.link(panel)
    inputs = []
    for size in (0.1, 0.1, 0.6):
        panel.data.size = size
        run(pool, frames=(1,))
        frame = record(out)["frames"]["1"]
        inputs.append(frame["inputs"])
    assert inputs[0] == inputs[1] != inputs[2]
    (area,) = (light for light in frame["lights"] if light["type"] == "area")
    np.testing.assert_allclose(np.linalg.norm(area["half_axes"], axis=1), 0.3)
