"""The caustics volume: the Empty that is drawn, its culling sides, and what is said where it is of no use."""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.operators.read.volume import Bounds
from dapple.tests.blender.glass_things import ball, dry_floor, material, read
from dapple.tests.blender.small_pool import solve_by_height, use_solver


@pytest.fixture
def scene(empty_scene, tmp_path):
    return dry_floor(empty_scene, tmp_path)


def box(size=1.0):
    empty = bpy.data.objects.new("Box", None)
    empty.empty_display_type, empty.empty_display_size = "CUBE", size
    bpy.context.scene.collection.objects.link(empty)
    return empty


def test_volume_is_the_cube_that_is_drawn(scene):
    ball("Ball", material("Clear"))
    empty = box(0.5)
    empty.location, empty.scale = (1, 2, 3), (2, 4, 6)
    volume = read(volume=Bounds("Box", ("-Z", "+X")))[0].volume
    corner = volume.matrix @ (1, 1, 1, 1)
    np.testing.assert_allclose(corner, (2, 4, 6, 1))
    np.testing.assert_allclose(volume.matrix @ (-1, -1, -1, 1), (0, 0, 0, 1), atol=1e-12)
    assert volume.culling == (False, True, False, False, True, False)
    assert read()[0].volume is None


def test_volume_that_holds_no_glass_is_said(scene):
    ball("Ball", material("Clear"))
    empty = box()
    empty.location = (0, 0, 2)
    assert read(volume=Bounds("Box"))[1] == []
    empty.location = (0, 0, 9)
    (warning,) = read(volume=Bounds("Box"))[1]
    assert "No glass or metal reaches into the caustics volume 'Box'" in warning


@pytest.mark.parametrize("name", ["Box", "Ball", "Nothing"])
def test_volume_that_is_none(scene, name):
    ball("Ball", material("Clear"))
    box().scale.y = 0.0
    with pytest.raises(DappleError, match=f"The caustics volume '{name}' is (flat|no Empty)"):
        read(volume=Bounds(name))


def test_settings_reach_the_bake_and_the_record(scene, tmp_path, monkeypatch):
    met = []

    def solve(kernel_scene, texels, settings, kept):
        met.append((kernel_scene, settings))
        water = replace(kernel_scene.water, positions=np.zeros((1, 3)))  # whose height is known
        return solve_by_height(replace(kernel_scene, water=water), texels, settings)

    use_solver(monkeypatch, solve)
    ball("Ball", material("Clear"))
    scene.dapple.bounces, scene.dapple.volume, scene.dapple.culling = 3, box(), {"-Z"}
    assert bpy.ops.dapple.bake_frame.poll()
    list(bake(bpy.context, request_from_scene(scene, frames=(1,))))
    ((kernel_scene, settings),) = met
    assert settings.bounces == 3
    assert kernel_scene.volume.culling == (False,) * 4 + (True, False)
    known = json.loads((tmp_path / "out" / "bake.json").read_text())
    assert known["water"] == []
    assert known["volume"] == {"name": "Box", "culling": ["-Z"]}
    (caster,) = known["frames"]["1"]["casters"]
    assert caster["name"] == "Ball"
    assert caster["glass"]["eta"] == 1.5
