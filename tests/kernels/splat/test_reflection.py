"""Light that the water reflects, against closed forms, and which of the water can send it to a receiver."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, flat, floor, quad, sun, transmitted, turned, water

from dapple.kernels.lit_water import light_water
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.rays import MISS, Tracer, soup
from dapple.kernels.scene import Receiver, Scene, Settings
from dapple.kernels.splat.meetings import Meetings
from dapple.kernels.splat.photon_splat import solve
from dapple.kernels.splat.reflection import may_reflect_onto, reflected

either = pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])


def bake(scene, resolution=64, tolerance=1e-3, points=False):
    return solve(
        scene, [rasterise(r, resolution) for r in scene.receivers], Settings(tolerance=tolerance, points=points)
    )


def wall(x=2.5, low=1.5, high=9.0, half=3.0):
    """A wall across x, facing the light that comes from -x."""
    return turned(quad("Wall", [[x, -half, low], [x, half, low], [x, half, high], [x, -half, high]]))


def slanted(degrees):
    """A sun whose light travels towards +x and down."""
    angle = np.radians(degrees)
    return sun((np.sin(angle), 0, -np.cos(angle)))


@pytest.mark.parametrize("degrees", [30.0, 60.0, 80.0])
@either
def test_still_water_mirrors_onto_a_wall(degrees, points):
    """Each point of the wall sees the sun once in the water: R(cos_i) sin(theta)."""
    scene = Scene(water(flat, 24, side=24.0), (wall(high=3.0),), (), (slanted(degrees),))
    image = bake(scene, 16, 1e-2 if points else 1e-4, points).images[0][..., 0]
    cos_i = np.cos(np.radians(degrees))
    expected = (1 - transmitted(cos_i)) * np.sqrt(1 - cos_i**2)
    assert image.mean() == pytest.approx(expected, rel=2e-2 if points else 1e-3)
    np.testing.assert_allclose(image[3:-3, 3:-3], expected, rtol=0.5 if points else 1e-9)


@pytest.mark.parametrize("degrees", [20.0, 45.0, 70.0])
@either
def test_what_is_reflected_and_what_passes_is_all_that_enters(degrees, points):
    """A floor below and a wall above, both so wide that nothing gets away: the books leave nothing over."""
    angle = np.radians(degrees)
    side = wall(high=1.6 + 5.0 / np.tan(angle))
    scene = Scene(water(flat, 16, side=4.0), (floor(side=16.0), side), (), (slanted(degrees),))
    d = bake(scene, 32, 1e-2, points).diagnostics
    entering, passed = 16.0 * np.cos(angle), transmitted(np.cos(angle))
    np.testing.assert_allclose(d.flux_received["Floor"], entering * passed, rtol=1e-9)
    np.testing.assert_allclose(d.flux_received["Wall"], entering * (1 - passed), rtol=1e-9)
    assert sum(np.abs(lost).sum() for lost in d.flux_lost.values()) < 1e-9 * entering


@either
def test_a_wall_through_the_water_line_gets_both(points):
    """Below the line refracted light, T cos(theta) tan(theta_t), above it R sin(theta), in one chart."""
    degrees = 60.0
    through = wall(x=2.5, low=0.0, high=3.0)
    scene = Scene(water(flat, 24, side=12.0), (through,), (), (slanted(degrees),))
    image = bake(scene, 32, 1e-2 if points else 1e-4, points).images[0][..., 0]
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    passed = transmitted(cosine)
    below, above = passed * cosine * np.tan(np.arcsin(sine / 1.333)), (1 - passed) * sine
    np.testing.assert_allclose(image[2:14, 3:-3], below, rtol=0.5 if points else 1e-9)
    np.testing.assert_allclose(image[18:30, 3:-3], above, rtol=1.0 if points else 1e-9)
    assert image[2:14].mean() / image[18:30].mean() == pytest.approx(below / above, rel=0.05)


def test_beams_equal_points_over_waves():
    """Two walls and a bridge above the waves: independent sums of one integral."""
    bridge = turned(quad("Bridge", [[-1, -2, 2.2], [1, -2, 2.2], [1, 2, 2.4], [-1, 2, 2.4]]))
    scene = Scene(water(five_sines, 160), (wall(x=2.03, low=1.3, high=2.5), bridge), (), (slanted(50.0),))
    beams, points = bake(scene, 32, 1e-3), bake(scene, 32, 2e-3, points=True)
    for one, other, name in zip(beams.images, points.images, ("Wall", "Bridge"), strict=True):
        assert one.mean() > 1e-3
        error = points.diagnostics.estimated_error + beams.diagnostics.estimated_error
        mean = np.mean([image.mean() for image in points.images])
        assert ((one - other) ** 2).mean() < 8 * error * mean**2, name
    for cause, watts in points.diagnostics.flux_lost.items():
        np.testing.assert_allclose(beams.diagnostics.flux_lost[cause], watts, rtol=3e-3, atol=1e-3)
    total = sum(beams.diagnostics.flux_received.values()) + sum(beams.diagnostics.flux_lost.values())
    np.testing.assert_allclose(total, beams.diagnostics.flux_in, rtol=1e-12)


@pytest.mark.parametrize("degrees", [20.0, 60.0, 85.0])
def test_no_water_that_mirrors_onto_a_receiver_is_missed(degrees):
    """Small things above the waves: every triangle from which a reflected ray meets one must be marked."""
    rng = np.random.default_rng(3)
    boxes = [c + rng.normal(size=(30, 3)) * 0.05 for c in ((0.5, 0.2, 1.8), (-1.0, 1.0, 2.4), (1.5, -1.4, 1.55))]
    things = [Receiver("Thing", b, rng.integers(0, 30, (60, 3)), np.zeros((60, 3, 2))) for b in boxes]
    w, light = water(five_sines, 64), slanted(degrees)
    lit = light_water(w, light)
    marked = may_reflect_onto(lit, things, Meetings.of(lit, w.twins, Tracer(*soup(())), 1.333))
    bary = rng.dirichlet([1, 1, 1], (len(w.triangles), 8))
    points = np.einsum("tsk,tkx->tsx", bary, w.positions[w.triangles]).reshape(-1, 3)
    normals = np.einsum("tsk,tkx->tsx", bary, w.normals[w.normal_triangles]).reshape(-1, 3)
    hit = Tracer(*soup(things)).first(points, reflected(normals, -light.direction)) != MISS
    hit = hit.reshape(-1, 8).any(1) & (lit.area > 0)
    assert hit.sum() > 20
    assert not (hit & ~marked).any()
    if degrees < 30:
        assert marked.mean() < 0.5, "marking everything is safe but useless"


def test_a_pool_whose_floor_lies_below_needs_no_second_look():
    w = water(five_sines, 32)
    lit = light_water(w, sun())
    meetings = Meetings.of(lit, w.twins, Tracer(*soup(())), 1.333)
    assert not may_reflect_onto(lit, [floor()], meetings).any()
    assert not may_reflect_onto(lit, [], meetings).any()


@either
def test_no_light_is_reflected_into_the_water(points):
    """Normals that lean far turn some light down into still water, which no light does: only what passes arrives."""
    w = water(flat, 12, side=4.0)
    normals = w.normals.copy()
    normals[::7] = [0.9, 0.3, 1.7]
    w, light = replace(w, normals=normals), slanted(70.0)
    answer = bake(Scene(w, (floor(side=40.0),), (), (light,)), 32, 1e-4, points)
    k = 60
    i, j = (v.ravel() for v in np.indices((k, k)))
    share = np.stack([i + 1 / 3, j + 1 / 3], 1)[i + j < k] / k
    share = np.concatenate([share, np.stack([i + 2 / 3, j + 2 / 3], 1)[i + j < k - 1] / k])
    corners = normals[w.triangles]
    corners = corners[corners.sum(1) @ light.direction < 0]  # triangles that face away on the whole take no light
    n = np.einsum("sk,tkx->tsx", np.c_[1 - share.sum(1), share], corners)
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    cosine = n @ -light.direction
    turned_down = 2 * cosine * n[..., 2] + light.direction[2] < 0
    assert (turned_down & (cosine > 0)).mean() > 0.01
    table = np.linspace(1e-6, 1.0, 4001)
    passes = np.interp(cosine, table, [transmitted(c) for c in table], left=0.0).mean()
    entering = answer.diagnostics.flux_in[0]
    assert answer.diagnostics.flux_received["Floor"][0] == pytest.approx(entering * passes, rel=2e-3)
    assert answer.diagnostics.flux_lost["reflected"][0] == pytest.approx(entering * (1 - passes), rel=2e-3)
