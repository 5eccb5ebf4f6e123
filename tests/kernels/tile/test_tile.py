"""A tile of water lights a tile of floor as a pool without an end would."""

from dataclasses import replace

import numpy as np
import pytest

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Point, Receiver, Scene, Settings, Sun
from dapple.tests.waves import faceted, grid, mesh_water, transmitted

WIDTH, LENGTH, DEPTH, N = 2.0, 1.5, 1.0, 48
TEXELS = 64
TILED = Settings(tile=True, tolerance=1e-3, resolution=TEXELS)


def waves(x, y, scale=1.0):
    """Height and slopes [m] of waves that repeat every WIDTH along x and LENGTH along y."""
    parts = ((1, 0, 0.03, 0.0), (1, 2, 0.012, 1.0), (-3, 1, 0.008, 2.0), (2, -3, 0.006, 0.5))
    height, along_x, along_y = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for m, n, amplitude, phase in parts:
        kx, ky = 2 * np.pi * m / WIDTH, 2 * np.pi * n / LENGTH
        height += scale * amplitude * np.sin(kx * x + ky * y + phase)
        along_x += scale * amplitude * kx * np.cos(kx * x + ky * y + phase)
        along_y += scale * amplitude * ky * np.cos(kx * x + ky * y + phase)
    return height, along_x, along_y


def tile_of_water(scale=1.0, moved=(0.0, 0.0)):
    """One tile over the floor's, of waves moved by so much [m]."""
    x, y, triangles = grid(N, 1.0)
    x, y = (x + 0.5) * WIDTH, (y + 0.5) * LENGTH
    height, along_x, along_y = waves(x - moved[0], y - moved[1], scale)
    normals = np.column_stack([-along_x, -along_y, np.ones_like(x)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return mesh_water(np.column_stack([x, y, DEPTH + height]), triangles, normals)


def floor(size=(WIDTH, LENGTH)):
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    return Receiver("Floor", np.column_stack([uv * size, np.zeros(4)]), triangles, uv[triangles])


def sun(direction=(0.4, 0.2, -1.0), angle=0.0):
    direction = np.array(direction) / np.linalg.norm(direction)
    return Sun("Sun", direction, np.full(3, 2.0), angle)


def tiled(water, light, **changes):
    scene = Scene(water, (floor(),), (), (light,))
    return solve(scene, (rasterise(floor(), TEXELS),), replace(TILED, **changes))


def apart(image, other):
    return ((image - other) ** 2).mean() / other.mean() ** 2


@pytest.mark.parametrize("angle", [0.0, np.radians(2.0)])
def test_water_moved_by_part_of_a_tile_moves_the_light_round(angle):
    """What lay at the border then lies inside: the map continues over each border as it does in the middle."""
    whole = tiled(tile_of_water(), sun(angle=angle)).images[0]
    moved = tiled(tile_of_water(moved=(WIDTH / 4, LENGTH / 2)), sun(angle=angle)).images[0]
    back = np.roll(moved, (-TEXELS // 2, -TEXELS // 4), axis=(0, 1))
    assert apart(back, whole) < 1e-6
    # And it is not for want of waves, nor of a shift.
    assert whole.std() > 0.3 * whole.mean() and apart(moved, whole) > 0.1


def test_all_that_enters_a_tile_of_calm_water_arrives_in_it():
    light = sun()
    solution = tiled(tile_of_water(scale=0.02), light)
    expected = 2.0 * -light.direction[2] * transmitted(-light.direction[2])
    np.testing.assert_allclose(solution.images[0].mean((0, 1)), expected, rtol=1e-4)
    work = solution.diagnostics
    np.testing.assert_allclose(work.flux_received["Floor"], expected * WIDTH * LENGTH, rtol=1e-4)
    np.testing.assert_allclose(work.flux_in, 2.0 * -light.direction[2] * WIDTH * LENGTH)
    np.testing.assert_allclose(sum(work.flux_lost.values()) + work.flux_received["Floor"], work.flux_in)


def test_light_is_kept_over_steep_water():
    """Of each triangle all that Fresnel lets in arrives, wherever it lands."""
    light, water = sun(), faceted(tile_of_water())
    v = water.positions[water.triangles]
    across = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]) / 2
    flux = 2.0 * -(across @ light.direction)
    normal = across / np.linalg.norm(across, axis=1, keepdims=True)
    enters = sum(f * transmitted(-n @ light.direction) for f, n in zip(flux, normal))
    received = tiled(water, light, surface="mesh").diagnostics.flux_received["Floor"]
    np.testing.assert_allclose(received, enters, rtol=2e-3)


def test_flat_shading_is_kept():
    water = faceted(tile_of_water())
    image = tiled(water, sun()).images[0]
    assert apart(image, tiled(tile_of_water(), sun()).images[0]) > 0.01


def test_a_low_sun_reaches_past_the_next_tile():
    light = sun((3.0, 0.0, -1.0))
    image = tiled(tile_of_water(scale=0.02), light).images[0]
    np.testing.assert_allclose(
        image.mean((0, 1)), 2.0 * -light.direction[2] * transmitted(-light.direction[2]), rtol=1e-3
    )


def broken(water):
    positions = water.positions.copy()
    positions[0, 2] += 0.01
    return replace(water, positions=positions)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"water": broken(tile_of_water())}, "the water does not tile: 1% of"),
        ({"receivers": (floor(), floor())}, "needs one receiver"),
        ({"receivers": (floor((1.0, LENGTH)),)}, "the water is wider than the receiver"),
        ({"receivers": (floor((WIDTH, 1.6)),)}, "the water does not tile"),
        ({"lights": (Point("Lamp", np.array([0, 0, 3.0]), np.ones(3)),)}, "needs parallel light"),
    ],
)
def test_what_cannot_tile_is_said(change, sentence):
    scene = replace(Scene(tile_of_water(), (floor(),), (), (sun(),)), **change)
    with pytest.raises(ValueError, match=sentence):
        solve(scene, (rasterise(scene.receivers[0], TEXELS),), TILED)


def test_other_objects_are_left_out_and_said():
    box = Occluder("Box", np.array([[0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]]), np.array([[0, 1, 2]]))
    scene = Scene(tile_of_water(), (floor(),), (box,), (sun(),))
    solution = solve(scene, (rasterise(floor(), TEXELS),), TILED)
    np.testing.assert_array_equal(solution.images[0], tiled(tile_of_water(), sun()).images[0])
    assert any("can be tiled" in sentence for sentence in solution.diagnostics.left_out)
