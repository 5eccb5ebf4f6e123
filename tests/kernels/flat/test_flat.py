"""Still water: closed forms, the complete method over water that is still, and the error that waves are said to add."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball
from waves import five_sines, flat, floor, grid, mesh_water, pool, quad, sun, transmitted, turned

from dapple.kernels.flat.paths import paths
from dapple.kernels.flat.still import Still
from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Point, Receiver, Settings, Spot, Water

LAMP = Point("Lamp", np.array([0.3, 0.2, 3.5]), np.array([9.0, 8.0, 7.0]))
SPOT = Spot("Spot", np.array([0.3, 0.2, 3.5]), np.array([9.0, 8.0, 7.0]), half_angle=0.5, blend=0.3)
WALL = turned(quad("Wall", [[2, -2, 0.2], [2, 2, 0.2], [2, 2, 3.0], [2, -2, 3.0]]))


def bed():
    """Uneven ground of 3 x 3 m."""
    x, y, triangles = grid(40, 3.0)
    relief = 0.2 * np.sin(1.9 * x + 0.4) * np.cos(1.5 * y) + 0.05 * np.sin(4 * x - 2 * y)
    return Receiver("Bed", np.stack([x, y, relief], 1), triangles, (np.stack([x, y], 1) / 3 + 0.5)[triangles])


def fish(z=0.7):
    body = ball(fine=12)
    return Occluder("Fish", body.positions * [0.3, 0.1, 0.1] + [0.2, -0.1, z], body.triangles)


def waves(scale):
    return lambda x, y: five_sines(x, y, scale)


def solved(scene, method, side=64, **words):
    texels = [rasterise(receiver, side) for receiver in scene.receivers]
    return solve(scene, texels, Settings(method, surface="mesh", **words))


def both(scene, side=64):
    """The Solution by still water, and its relative mean squared error against beams."""
    answer, true = solved(scene, "flat", side), solved(scene, "photon_splat", side, tolerance=1e-5)
    own, wanted = (np.concatenate([i[..., 0].ravel() for i in s.images]) for s in (answer, true))
    return answer, ((own - wanted) ** 2).mean() / (wanted**2).mean()


def balance(diagnostics):
    """What came in less what was booked, over what came in."""
    booked = sum(sum(books.values()) for books in (diagnostics.flux_received, diagnostics.flux_lost))
    return np.abs(booked / diagnostics.flux_in - 1).max()


def test_level_floor_is_the_textbook_at_any_depth():
    direction = (np.sin(np.radians(30)), 0, -np.cos(np.radians(30)))
    for depth in (0.0, -3.0):
        scene = pool(flat, quads=4, direction=direction, receivers=[floor(z=depth)], side=12.0)
        answer = solved(scene, "flat")
        np.testing.assert_allclose(answer.images[0], np.cos(np.radians(30)) * transmitted(np.cos(np.radians(30))))
        np.testing.assert_allclose(answer.images[0], 0.8475, atol=1e-4)
        assert answer.diagnostics.estimated_error < 1e-12 and balance(answer.diagnostics) < 1e-12


def test_absorption_follows_beer_along_the_bent_way():
    scene = replace(pool(flat, quads=4, side=12.0), sigma_a=np.array([0.4, 0.1, 0.0]))
    image = solved(scene, "flat").images[0]
    cos_i = -scene.lights[0].direction[2]
    cos_t = np.sqrt(1 - (1 - cos_i**2) / scene.eta**2)
    clear = cos_i * transmitted(cos_i)
    np.testing.assert_allclose(image, clear * np.exp(-scene.sigma_a * 1.5 / cos_t) * np.ones_like(image))


def test_walls_and_slopes_take_the_cosine_of_the_bent_light():
    """E = E_perp T cos i / cos t |t.n| on every side, and (1 - T) |r.n| above the water."""
    scene = pool(flat, quads=4, receivers=[WALL], side=24.0)
    image = solved(scene, "flat").images[0][..., 0]
    d, n = scene.lights[0].direction, np.array([-1.0, 0, 0])
    cos_i = -d[2]
    cos_t = np.sqrt(1 - (1 - cos_i**2) / scene.eta**2)
    below = transmitted(cos_i) * cos_i / cos_t * -(d / scene.eta) @ n
    above = (1 - transmitted(cos_i)) * -d @ n
    np.testing.assert_allclose(image[:29], below)
    np.testing.assert_allclose(image[31:], above)


def test_a_tilted_plane_is_a_plane():
    x, y, triangles = grid(24, 12.0)
    n = np.array([-0.2, -0.1, 1.0]) / np.sqrt(1.05)
    water = mesh_water(np.stack([x, y, 1.5 + 0.2 * x + 0.1 * y], 1), triangles, np.tile(n, (len(x), 1)))
    scene = replace(pool(flat, quads=2, direction=(0, 0, -1)), water=water)
    cos_i = n[2]
    cos_t = np.sqrt(1 - (1 - cos_i**2) / scene.eta**2)
    expected = transmitted(cos_i) * cos_i / cos_t * (1 / scene.eta - (cos_i / scene.eta - cos_t) * n[2])
    np.testing.assert_allclose(solved(scene, "flat").images[0], expected)


def test_ways_of_a_lamp_obey_snell_and_fermat():
    still = Still(pool(flat, quads=2).water, 0.1)
    rng = np.random.default_rng(3)
    p = still.to_plane(np.column_stack([rng.uniform(-2, 2, (400, 2)), 1.5 - rng.exponential(1.0, 400)]))
    p[:2, 0], p[2, 1] = still.to_plane(LAMP.position[None])[:2, 0], -1e-9  # right below it; hardly under water
    found = paths(still, LAMP, p, 1.333, through=True)
    sines = [np.linalg.norm(v[:2], axis=0) for v in (found.towards, found.arrives)]
    np.testing.assert_allclose(sines[0], 1.333 * sines[1], atol=1e-9)
    enters = np.concatenate([found.enters, np.zeros((1, 400))])
    np.testing.assert_allclose(enters + found.length * found.arrives, p, atol=1e-9)
    lamp = still.to_plane(LAMP.position[None])
    np.testing.assert_allclose(enters + found.away * found.towards, np.broadcast_to(lamp, p.shape), atol=1e-9)


@pytest.mark.parametrize("texel", [0.05, 0.0005])  # finer than the cells of the outline ever are
def test_a_texel_that_ends_at_the_rim_is_all_lit(texel):
    still = Still(pool(flat, quads=2, side=4.0).water, texel)
    aside = np.array([-0.5, 0.0, 0.5]) * texel
    edge = still.to_plane(np.array([[2.0, 0.3, 1.5]]) + np.outer(aside, [1, 0, 0]))[:2]
    np.testing.assert_allclose(still.covered(*edge), [1, 0.5, 0], atol=1e-6)


def test_a_closed_body_of_water_has_the_outline_of_its_top():
    open_water = pool(flat, quads=8, side=4.0).water
    bottom = open_water.positions - [0, 0, 1.0]
    count = len(bottom)
    ring = np.flatnonzero(np.abs(bottom[:, :2]).max(1) > 2 - 1e-9)
    ring = ring[np.argsort(np.arctan2(*bottom[ring, :2].T))]
    after = np.roll(ring, -1)
    sides = np.concatenate(
        [np.stack([ring, after + count, after], 1), np.stack([ring, ring + count, after + count], 1)]
    )
    triangles = np.concatenate([open_water.triangles, open_water.triangles[:, ::-1] + count, sides])
    positions = np.concatenate([open_water.positions, bottom])
    facets = np.cross(*(positions[triangles[:, k]] - positions[triangles[:, 0]] for k in (1, 2)))
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(facets))[:, None], 3, 1)
    still = Still(Water("Box", positions, triangles, facets, rows, build_twins(triangles)), 0.1)
    assert still.area() == pytest.approx(16.0)


CASES = {
    "level": {},
    "uneven": {"receivers": [bed()]},
    "walls": {"receivers": [floor(), WALL]},
    "shadows": {"receivers": [bed()], "occluders": [fish(), fish(1.9)]},
    "lamp": {"lights": (LAMP,)},
    "spot": {"lights": (SPOT,)},
    "lamp and walls": {"receivers": [floor(), WALL], "lights": (LAMP,)},
    "rim": {"side": 4.0},
    "rim and fish": {"side": 3.6, "occluders": [fish()]},
    "wide sun": {"lights": (replace(sun(), angle=0.03),)},
    "low sun": {"direction": (1.0, 0.3, -1.0)},
    "murky": {"receivers": [bed()], "sigma_a": np.array([0.4, 0.1, 0.05])},
}


def scene_of(case, scale, quads=96):
    words = dict(CASES[case])
    changes = {name: words.pop(name) for name in ("lights", "sigma_a") if name in words}
    return replace(pool(waves(scale), quads=quads, **{"side": 6.0, **words}), **changes)


@pytest.mark.parametrize("case", CASES)
def test_still_water_is_what_beams_make_of_it(case):
    """Level and lit by suns it is exact; elsewhere what differs is the value at a texel's centre from the mean over
    it, most of all on the edges of shadows."""
    answer, error = both(scene_of(case, 0.0, quads=48))
    edges = {"shadows": 2e-3, "rim and fish": 2e-3, "lamp and walls": 2e-3, "walls": 5e-4}
    exact = ("level", "rim", "low sun", "wide sun")
    assert error < (1e-9 if case in exact else edges.get(case, 1e-4))
    assert error <= 4 * answer.diagnostics.estimated_error + (1e-9 if case in exact else 1e-5)
    assert balance(answer.diagnostics) < 1e-9


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("scale", [0.03, 0.1])
def test_the_estimate_is_what_the_waves_add(case, scale):
    answer, error = both(scene_of(case, scale))
    assert error / 2 < answer.diagnostics.estimated_error < 2.5 * error


def test_waves_that_only_lie_elsewhere_add_nothing():
    """Ripples in a corner of a wide lake are no error of the floor's light, and ripples over a small floor are not
    averaged with the calm round it."""

    def ripples(x, y):
        near = np.exp(-(((x - 8) ** 2 + (y - 8) ** 2) / 4))
        return near * 0.01 * np.sin(9 * x), near * (0.09 * np.cos(9 * x) - 0.005 * (x - 8) * np.sin(9 * x)), 0 * x

    scene = pool(ripples, quads=400, side=24.0)
    far, error = both(scene)
    assert error < 1e-6 and far.diagnostics.estimated_error < 1e-6
    away = floor()
    near = replace(
        scene, receivers=(Receiver("Floor", away.positions + np.array([8, 8, 0]), away.triangles, away.uvs),)
    )
    answer, error = both(near)
    assert error > 1e-2 and error / 2 < answer.diagnostics.estimated_error < 2 * error


def test_says_what_it_leaves_out():
    d = solved(pool(), "flat").diagnostics
    assert d.method == "flat" and d.surface == "the mean plane of the mesh"
    assert any("waves" in sentence for sentence in d.left_out)
    assert d.estimated_error > 0.3


def test_light_from_below_and_no_water_light_nothing():
    below = pool(flat, quads=4, direction=(0, 0, -1))
    lamp = replace(LAMP, position=np.array([0.0, 0.0, 1.0]))
    assert not solved(replace(below, lights=(lamp,)), "flat").images[0].any()
