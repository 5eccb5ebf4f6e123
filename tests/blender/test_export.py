"""What is made of baked maps: the numbers are those that were baked, and the files say what they are."""

import json

import bpy
import numpy as np
import pytest

from dapple.operators import cli
from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.errors import DappleError
from dapple.operators.maps.export import Export, export
from dapple.operators.maps.read_map import read_map
from dapple.operators.show.attach import attach
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import build_pool, files_in, solve_by_height, use_solver


def solve(scene, texels, settings, reconstruction=None, anchor=None):
    """As `solve_by_height`, but the map grows from left to right, is 0 in its last row, and green is half."""
    solution = solve_by_height(scene, texels, settings)
    (image,) = solution.images
    image *= np.linspace(0.5, 1.5, image.shape[1])[None, :, None] * np.array([1.0, 0.5, 0.25])
    image[-1] = 0
    return solution


@pytest.fixture
def baked(empty_scene, tmp_path, monkeypatch):
    """Ten frames of the small pool, whose light is the height of its water times a ramp; gives the folder of maps."""
    build_pool(empty_scene, tmp_path / "maps")
    empty_scene.frame_end = 10
    use_solver(monkeypatch, solve)
    list(bake(bpy.context, request_from_scene(empty_scene)))
    return tmp_path / "maps"


def make(baked, **wish):
    request = request_from_scene(bpy.context.scene)
    return list(export(bpy.context, request, Export(**wish)))


def told(baked, form):
    said = json.loads((baked / "export" / "Floor" / f"{form}.json").read_text())
    assert json.loads((baked / "bake.json").read_text())["exports"][form]["Floor"] == said
    return said


def original(baked, frame):
    return read_map(baked / "Floor" / f"caustics_{frame:04d}.exr").astype(float)


def png(path):
    """(H,W,3) of a PNG by Blender's reader, white as 1."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, -1)[..., :3]
    assert image.is_float
    bpy.data.images.remove(image)
    return pixels


def test_png_gives_the_values_back_by_its_scale(baked):
    make(baked, png=True)
    said = told(baked, "sequence")
    assert said["files"] == [f"caustics_{n:04d}.png" for n in range(1, 11)]
    # The one scale of all frames: the largest value of the last.
    assert said["value_scale"] == pytest.approx(original(baked, 10).max(), rel=1e-6)
    for frame in (1, 10):
        back = png(baked / "export" / "Floor" / f"caustics_{frame:04d}.png") * said["value_scale"]
        np.testing.assert_allclose(back, original(baked, frame), atol=0.51 / 65535 * said["value_scale"])


def test_attach_undoes_the_scale(baked):
    make(baked, png=True)
    attach(bpy.context, ["Floor"], baked / "export")
    nodes = bpy.data.objects["Floor"].material_slots[0].material.node_tree.nodes
    scaled = nodes["Dapple Albedo x Irradiance"].inputs[1].links[0].from_node
    assert scaled.operation == "SCALE"
    assert scaled.inputs["Scale"].default_value == pytest.approx(told(baked, "sequence")["value_scale"])
    assert scaled.inputs[0].links[0].from_node.image.filepath.endswith("caustics_0001.png")
    (baked / "export" / "Floor" / "sequence.json").unlink()
    with pytest.raises(DappleError, match=r"sequence\.json does not tell .* export again"):
        attach(bpy.context, ["Floor"], baked / "export")


def test_atlas_holds_all_frames_from_the_top_left(baked):
    make(baked, form="atlas", frames=tuple(range(1, 8)))
    said = told(baked, "atlas")
    assert (said["rows"], said["columns"], said["frames"], said["resolution"]) == (3, 3, 7, [16, 16])
    sheet = read_exr(baked / "export" / "Floor" / "atlas.exr").astype(float)
    assert sheet.shape == (48, 48, 3)
    for index in range(9):
        row, column = divmod(index, 3)
        cell = sheet[16 * (2 - row) :][:16, 16 * column :][:, :16]
        np.testing.assert_array_equal(cell, original(baked, index + 1) if index < 7 else 0)
    assert (said["frame_rate"], said["value_scale"], said["loop"]) == (24.0, 1.0, False)


def test_smaller_frames_keep_the_light(baked):
    make(baked, form="atlas", size=4, frames=(3,))
    sheet = read_exr(baked / "export" / "Floor" / "atlas.exr").astype(float)
    assert sheet.shape == (4, 4, 3)
    np.testing.assert_allclose(sheet.mean((0, 1)), original(baked, 3).mean((0, 1)), rtol=1e-3)
    with pytest.raises(DappleError, match="16 texels cannot be reduced to 5; set one of 16"):
        make(baked, size=5)


@pytest.mark.parametrize("as_png", [False, True])
def test_cookie_is_light_over_its_mean_where_there_is_any(as_png, baked):
    make(baked, form="cookie", png=as_png)
    said, folder = told(baked, "cookie"), baked / "export" / "Floor"
    frames = [png(folder / f) if as_png else read_exr(folder / f).astype(float) for f in said["files"]]
    cookie = np.stack(frames) * said["value_scale"]
    assert cookie[:, :-1].mean((0, 1, 2)) == pytest.approx([1, 1, 1], rel=1e-3)
    assert not cookie[:, -1].any()
    np.testing.assert_allclose(cookie[4] * said["mean"], original(baked, 5), rtol=1e-3, atol=1e-3)


def test_blended_loop_goes_through_its_joins_as_the_animation_does(baked):
    make(baked, loop=4)
    said, folder = told(baked, "sequence"), baked / "export" / "Floor"
    assert said["loop"] and said["loop_by"] == "the last 4 frames are blended into the first"
    assert said["files"] == [f"caustics_{n:04d}.exr" for n in range(1, 7)]
    frames = [read_exr(folder / f).astype(float) for f in said["files"]]
    # After frame 6, the last, comes frame 7; after the blend frame 5.
    np.testing.assert_array_equal(frames[0], original(baked, 7))
    np.testing.assert_array_equal(frames[4:], [original(baked, 5), original(baked, 6)])
    for k in (1, 2, 3):
        mixed = k / 4 * original(baked, 1 + k) + (1 - k / 4) * original(baked, 7 + k)
        np.testing.assert_allclose(frames[k], mixed, rtol=2**-11)
        assert frames[k].sum() == pytest.approx(mixed.sum(), rel=1e-3)


def drive(expression):
    water = bpy.data.objects["Water"]
    water.animation_data.drivers[0].driver.expression = expression


@pytest.mark.parametrize("frame", ["frame", "min(frame, 9)"])
def test_period_of_the_motion_is_found(frame, baked):
    """After half a period the water is where it was, and moves the other way: that is no loop. What is keyed over one
    period stands still after it."""
    drive(f"1 + 0.1 * sin(2 * pi * ({frame} - 1) / 8)")
    make(baked, loop=0)
    said = told(baked, "sequence")
    assert (said["frames"], said["loop"]) == (8, True)
    assert "repeats after 8 frames" in said["loop_by"]
    last = read_exr(baked / "export" / "Floor" / "caustics_0008.exr")
    np.testing.assert_array_equal(last, original(baked, 8))
    assert bpy.context.scene.frame_current == 1


def test_what_never_comes_back_is_blended(baked):
    make(baked, loop=0)
    assert told(baked, "sequence")["loop_by"] == "the last 2 frames are blended into the first"


def test_what_stands_still_loops_as_it_is(baked):
    drive("1.0")
    make(baked, loop=0)
    assert (told(baked, "sequence")["frames"], told(baked, "sequence")["loop"]) == (10, True)


def test_files_of_an_earlier_export_do_not_mix_with_the_new(baked):
    make(baked, png=True)
    make(baked, frames=(2, 3))
    left = files_in(baked / "export" / "Floor")
    assert left == ["caustics_0002.exr", "caustics_0003.exr", "sequence.json"]


def test_a_new_bake_forgets_what_was_exported_before(baked):
    make(baked, png=True)
    bpy.context.scene.dapple.depth = "FULL"
    list(bake(bpy.context, request_from_scene(bpy.context.scene, frames=(1,))))
    assert "exports" not in json.loads((baked / "bake.json").read_text())


@pytest.mark.parametrize(
    ("wish", "sentence"),
    [
        ({"frames": (3, 99)}, "Frame 99 is not in"),
        ({"receivers": ("Roof",)}, "has no map of 'Roof'"),
        ({"loop": 6}, "too few to blend 6"),
        ({"loop": 2, "frames": (1, 2, 4, 5)}, "Frame 3 is not baked"),
    ],
)
def test_what_cannot_be_made_is_said_and_nothing_is_written(wish, sentence, baked):
    with pytest.raises(DappleError, match=sentence):
        make(baked, **wish)
    assert not (baked / "export").exists()


def test_maps_are_never_written_over(baked):
    with pytest.raises(DappleError, match="holds the baked maps themselves"):
        make(baked, out=baked)


def test_command_and_button(baked, capsys):
    assert cli.main(["export", "--atlas", "--png", "--loop", "2", "--size", "8"]) == 0
    assert "8 frames, the last 2 frames are blended" in capsys.readouterr().out
    assert told(baked, "atlas")["resolution"] == [8, 8]
    assert bpy.ops.dapple.export(form="cookie", use_loop=True, blend=3) == {"FINISHED"}
    assert told(baked, "cookie")["frames"] == 7
    (baked / "bake.json").unlink()
    assert cli.main(["export", "--cookie"]) == 1
    assert "is not in" in capsys.readouterr().err
