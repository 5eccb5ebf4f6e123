"""The sun map: still water's light, in the source's pattern, and honest about what it is."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, flat, floor, mesh_water, pool, quad, turned

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Point, Settings

WALL = turned(quad("Wall", [[2, -2, 0.2], [2, 2, 0.2], [2, 2, 3.0], [2, -2, 3.0]]))


def solved(scene, method="sun_map", side=64, **words):
    texels = [rasterise(receiver, side) for receiver in scene.receivers]
    return solve(scene, texels, Settings(method, surface="mesh", **words))


def swell(x, y):
    return 0.02 * np.sin(4 * x), 0.08 * np.cos(4 * x), np.zeros_like(x)


@pytest.mark.parametrize("receivers", [[floor()], [floor(), WALL]])
def test_still_water_is_still_water(receivers):
    scene = pool(flat, quads=8, receivers=receivers, side=5.0)
    answer, still = solved(scene), solved(scene, "flat")
    for one, other in zip(answer.images, still.images, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    assert answer.diagnostics.estimated_error == pytest.approx(still.diagnostics.estimated_error, abs=1e-9)


@pytest.mark.parametrize("depth", [1.5, 3.0])
def test_the_pattern_is_the_source_s_look_up(depth):
    """1 - (0.8 d |gradient| / 0.5)^2 of the water straight above, whatever the sun's direction, with the light of still
    water in all."""
    scene = pool(swell, quads=256, receivers=[floor(z=1.5 - depth)], side=8.0)
    answer, still = solved(scene), solved(scene, "flat")
    x = (np.arange(64) + 0.5) / 16 - 2
    height, slope, _ = swell(x, x)
    expected = np.maximum(1 - (0.8 * (depth + height) * slope / 0.5) ** 2, 0)
    row = answer.images[0][32, :, 0]
    np.testing.assert_allclose(row / row.mean(), expected / expected.mean(), atol=3e-3)
    received = [s.diagnostics.flux_received["Floor"] for s in (answer, still)]
    np.testing.assert_allclose(*received, rtol=1e-9)
    booked = sum(sum(b.values()) for b in (answer.diagnostics.flux_received, answer.diagnostics.flux_lost))
    np.testing.assert_allclose(booked, answer.diagnostics.flux_in, rtol=1e-9)


def test_deep_water_shows_less_of_the_sun():
    shallow, deep = (solved(pool(swell, receivers=[floor(z=z)], side=9.0)).images[0] for z in (1.0, -2.0))
    assert deep.std() > 3 * shallow.std()


def test_it_is_a_look_and_says_so():
    scene = pool(five_sines, side=6.0, direction=(0, 0, -1))
    answer, true = solved(scene), solved(scene, "photon_splat", tolerance=1e-3)
    image, light = (s.images[0][..., 0] for s in (answer, true))
    assert 0.0 < np.corrcoef(image.ravel(), light.ravel())[0, 1] < 0.6
    error = ((image - light) ** 2).mean() / light.mean() ** 2
    assert error / 2.5 < answer.diagnostics.estimated_error < 2.5 * error
    assert any("not the light" in sentence for sentence in answer.diagnostics.left_out)


def test_lamps_and_waters_seen_from_below():
    lamp = Point("Lamp", np.array([0.3, 0.2, 3.5]), np.array([9.0, 8.0, 7.0]))
    scene = replace(pool(swell), lights=(lamp,))
    w = scene.water
    sunk = replace(scene, water=mesh_water(w.positions, w.triangles[:, ::-1], -w.normals))
    np.testing.assert_allclose(solved(scene).images[0], solved(sunk).images[0], rtol=1e-6)
