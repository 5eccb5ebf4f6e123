"""Receivers whose UVs lie in several UDIM tiles: each tile's light where it belongs, in EEVEE and in Cycles."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.operators.maps.write import map_path, write_exr  # noqa: E402
from dapple.operators.show.attach import attach, detach, refresh, show_images, show_maps  # noqa: E402
from dapple.tests.blender.attach_scene import plane, principled, state  # noqa: E402
from dapple.tests.blender.test_attach_maps import cycles, diffuse, look_at_the_floor  # noqa: E402

TILES = {1001: 1.0, 1002: 3.0, 1011: 5.0, 1012: 7.0}  # and the irradiance in frame 1 [W/m^2]; in frame 2 twice that


@pytest.fixture
def tiles(empty_scene, tmp_path):
    """A floor of 1 m, as large as the camera sees, in four tiles, and their maps in two frames."""
    floor = plane("Floor", diffuse(), size=1.0)
    low, high = (floor.data.vertices[k].co.copy() for k in (0, 2))
    floor.data.clear_geometry()
    at = [(low.x + (high.x - low.x) * i / 2, low.y + (high.y - low.y) * j / 2, 0) for j in range(3) for i in range(3)]
    faces = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
    floor.data.from_pydata(at, [], faces)
    layer = floor.data.uv_layers.new(name="Tiles")
    layer.data.foreach_set("uv", [x for face in faces for v in face for x in (v % 3, v // 3)])
    layer.active_render = True
    write_tiles(tmp_path, 1.0)
    return tmp_path


def write_tiles(folder, factor):
    for tile, value in TILES.items():
        for frame in (1, 2):
            write_exr(map_path(folder, f"Floor [{tile}]", frame), np.full((4, 4, 3), factor * value * frame))


def picture(scene, path):
    """Render; the irradiance (4,4,4,4): tile row, pixel row, tile column, pixel column, from the bottom left."""
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.filter_size = 0.01  # no pixel sees what its neighbours do
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    pixels = np.empty(8 * 8 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(2, 4, 2, 4, 4)[..., 0] * math.pi / 0.5


def assert_tiles(shown, factor):
    for k, value in enumerate(TILES.values()):
        np.testing.assert_allclose(shown[k // 2, :, k % 2], factor * value, rtol=0.02, err_msg=str(shown))


@pytest.mark.parametrize("engine", ["eevee", "cycles"])
def test_each_tile_shows_its_own_map_up_to_its_border(tiles, engine, tmp_path):
    scene = bpy.context.scene
    look_at_the_floor(scene)
    if engine == "cycles":
        cycles(scene)
        scene.cycles.pixel_filter_type = "BOX"
    before = state()[:3]  # all but the images, among which the render's comes
    assert attach(bpy.context, ["Floor"], tiles) == []
    for frame in (1, 2):
        scene.frame_set(frame)
        assert_tiles(picture(scene, tmp_path / "view.exr"), frame)
    write_tiles(tiles, 10.0)
    refresh(["Floor"], tiles)
    assert_tiles(picture(scene, tmp_path / "view.exr"), 20.0)
    detach(bpy.context)
    assert state()[:3] == before


def test_other_tiles_after_a_new_bake_get_other_nodes(tiles):
    attach(bpy.context, ["Floor"], tiles)
    for frame in (1, 2):
        map_path(tiles, "Floor [1012]", frame).unlink()
    refresh(["Floor"], tiles)
    material = bpy.data.objects["Floor"].material_slots[0].material
    shown = [node.image.name for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage"]
    assert sorted(shown) == ["Dapple Floor [1001]", "Dapple Floor [1002]", "Dapple Floor [1011]"]
    assert len(bpy.data.images) == 3


def test_a_frame_that_one_tile_lacks_is_said(tiles):
    map_path(tiles, "Floor [1012]", 2).unlink()
    (note,) = attach(bpy.context, ["Floor"], tiles)
    assert note == "'Floor' has no map for 1 frame(s) from 2 on: bake these too."


def test_what_was_baked_later_is_shown_tiles_or_one_map(tiles):
    write_exr(map_path(tiles, "Floor", 1), np.ones((4, 4, 3)))
    attach(bpy.context, ["Floor"], tiles)
    assert [image.name for image in bpy.data.images] == ["Dapple Floor"]
    write_tiles(tiles, 1.0)
    attach(bpy.context, ["Floor"], tiles)
    assert len(bpy.data.images) == 4


def test_a_preview_shows_tiles_and_gives_back_their_maps(tiles):
    attach(bpy.context, ["Floor"], tiles)
    before = state()
    images = {f"Floor [{tile}]": bpy.data.images.new(f"live {tile}", 4, 4) for tile in TILES}
    assert show_images(bpy.context, ["Floor"], images, ()) == []
    material = bpy.data.objects["Floor"].material_slots[0].material
    shown = {node.image for node in material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage"}
    assert shown == set(images.values())
    show_maps()
    for image in images.values():
        bpy.data.images.remove(image)
    assert state() == before


def test_an_object_named_as_a_tile_shows_its_map(empty_scene, tmp_path):
    plane("Floor [1001]", principled())
    write_exr(map_path(tmp_path, "Floor [1001]", 1), np.ones((4, 4, 3)))
    attach(bpy.context, ["Floor [1001]"], tmp_path)
    assert [image.name for image in bpy.data.images] == ["Dapple Floor [1001]"]
