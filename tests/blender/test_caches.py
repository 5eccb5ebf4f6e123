"""Frames that simulations make of the one before are the same whether they are jumped to or played to."""

import bpy
import numpy as np
import pytest

from dapple.kernels.scene import Settings
from dapple.operators.bake.bake import BakeRequest, bake
from dapple.operators.read.caches import Player
from dapple.operators.read.mesh_arrays import read_geometry
from dapple.tests.blender import waters
from dapple.tests.blender.small_pool import add_grid


def cloth(_scene, _folder):
    water = waters.surface("Water")
    pins = water.vertex_groups.new(name="Pins")
    pins.add([0, waters.QUADS], 1.0, "REPLACE")
    water.modifiers.new("Cloth", "CLOTH").settings.vertex_group_mass = "Pins"
    return (water.name,)


def soft_body(_scene, _folder):
    water = waters.surface("Water")
    water.modifiers.new("Soft", "SOFT_BODY")
    return (water.name,)


def simulation_zone(_scene, _folder):
    """Geometry nodes that lift the surface by a centimetre on every frame that is played."""
    water = waters.surface("Water")
    tree, enter, leave = waters._nodes("Zone", water)
    begin, end = (tree.nodes.new(f"GeometryNodeSimulation{side}") for side in ("Input", "Output"))
    begin.pair_with_output(end)
    lift = tree.nodes.new("GeometryNodeSetPosition")
    lift.inputs["Offset"].default_value = (0, 0, 0.01)
    tree.links.new(enter.outputs[0], begin.inputs["Geometry"])
    tree.links.new(begin.outputs["Geometry"], lift.inputs[0])
    tree.links.new(lift.outputs[0], end.inputs["Geometry"])
    tree.links.new(end.outputs["Geometry"], leave.inputs[0])
    return (water.name,)


def shape():
    """Positions of the water on the current frame."""
    shown = bpy.data.objects["Water"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = shown.to_mesh()
    try:
        return read_geometry(mesh, np.array(shown.matrix_world, dtype=float)).positions
    finally:
        shown.to_mesh_clear()


@pytest.mark.parametrize("build", [waters.dynamic_paint, cloth, soft_body, simulation_zone])
def test_jump_to_a_frame_shows_what_playing_does(empty_scene, tmp_path, build):
    found = []
    for steps in (range(1, 7), (6,), (1, 3, 6), (6, 3)):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        build(bpy.context.scene, tmp_path)
        player = Player(bpy.context.scene.name)
        for frame in steps:
            player.go(frame)
        found.append(shape())
    played, jumped, skipped, _ = found
    np.testing.assert_array_equal(jumped, played)
    np.testing.assert_array_equal(skipped, played)
    bpy.context.scene.frame_set(1)
    assert np.abs(played - shape()).max() > 1e-3


def test_frames_are_not_played_where_nothing_is_simulated(empty_scene, tmp_path):
    waters.wave(empty_scene, tmp_path)
    played = []
    bpy.app.handlers.frame_change_post.append(lambda scene, _: played.append(scene.frame_current))
    Player(empty_scene.name).go(6)
    bpy.app.handlers.frame_change_post.pop()
    assert played == [6]


def test_a_cache_file_that_is_gone_is_said(empty_scene, tmp_path):
    names = waters.alembic(empty_scene, tmp_path)
    add_grid("Floor", 0.0).scale = 1.5, 1.5, 1.0
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    empty_scene.collection.objects.link(sun)
    request = BakeRequest(names, ("Floor",), (1,), tmp_path / "out", Settings(resolution=16))
    (step,) = bake(bpy.context, request)
    assert step.warnings == ()
    (tmp_path / "water.abc").unlink()
    (step,) = bake(bpy.context, request)
    assert any("'Water' takes its shape from" in said and "which is not there" in said for said in step.warnings)
