"""What the last bake is said to have been, and the picture of its texels."""

import json

import bpy
import numpy as np
import pytest

from dapple.kernels.status import Status
from dapple.operators.bake.last_bake import last_bake
from dapple.operators.maps import overlay
from dapple.tests.blender.small_pool import build_pool, solve_by_height, use_solver


@pytest.fixture
def pool(empty_scene, tmp_path, monkeypatch):
    build_pool(empty_scene, tmp_path / "out")

    def solve(scene, texels, settings, reconstruction=None):
        solution = solve_by_height(scene, texels, settings)
        solution.status[0][:2] = Status.LOST
        solution.diagnostics.texels = {"lit": 224, "lost": 32}
        return solution

    use_solver(monkeypatch, solve)
    return empty_scene


def test_the_frame_at_hand_is_told_or_the_one_next_to_it(pool, tmp_path):
    assert last_bake(tmp_path / "out", 1) is None
    bpy.ops.dapple.bake_animation()
    bake = last_bake(tmp_path / "out", 2)
    assert (bake.frame, bake.method, bake.reason) == (2, "by_height", "a test asked for it")
    assert bake.watts == 4.0
    assert (bake.received, bake.lost) == (0.75, {"rim": 0.25})
    assert bake.odd == {"lost": 32}
    assert last_bake(tmp_path / "out", 90).frame == 3


def test_a_new_bake_is_seen_and_a_broken_record_is_none(pool, tmp_path):
    pool.frame_set(2)
    bpy.ops.dapple.bake_frame()
    assert last_bake(tmp_path / "out", 3).frame == 2
    bpy.ops.dapple.bake_animation()
    assert last_bake(tmp_path / "out", 3).frame == 3
    (tmp_path / "out" / "bake.json").write_text(json.dumps({"frames": {"1": {}}}))
    assert last_bake(tmp_path / "out", 3) is None


def test_overlay_paints_what_became_of_each_texel(pool):
    for _ in range(2):
        assert bpy.ops.dapple.show_status() == {"FINISHED"}
    (image,) = bpy.data.images
    assert image.name == "Dapple Status Floor"
    pixels = np.array(image.pixels[:]).reshape(16, 16, 4)
    np.testing.assert_allclose(pixels[:2, :, :3], np.broadcast_to(overlay.COLOURS[Status.LOST], (2, 16, 3)), atol=1e-6)
    np.testing.assert_allclose(pixels[2:, :, :3], 0.5)


def test_overlay_follows_the_resolution(pool):
    bpy.ops.dapple.show_status()
    pool.dapple.resolution = 32
    bpy.ops.dapple.show_status()
    assert [tuple(image.size) for image in bpy.data.images] == [(32, 32)]


def test_every_status_has_a_colour_of_its_own():
    assert set(overlay.COLOURS) == set(Status)
    assert len(set(overlay.COLOURS.values())) == len(Status)
    assert overlay.colour_name("lost") == "red"
    assert overlay.colour_name("lit") == ""
