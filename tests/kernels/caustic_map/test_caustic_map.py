"""Caustics maps: look-ups against rays, splats against still water and beams, two surfaces against slab and ball."""

from dataclasses import replace

import numpy as np
import pytest
from casters import GLASS, SILVER, ball, no_water, slab
from waves import five_sines, flat, floor, grid, pool, quad, sun, turned

from dapple.kernels.casters import Glass
from dapple.kernels.caustic_map.bending import Backs, Seen, from_casters
from dapple.kernels.caustic_map.estimate import estimate, newton, start
from dapple.kernels.caustic_map.gaussian import splat
from dapple.kernels.caustic_map.meshes import Shaded, Solids
from dapple.kernels.caustic_map.positions import Positions
from dapple.kernels.caustic_map.view import Raster, View
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Point, Receiver, Scene, Settings

LAMP = Point("Lamp", np.array([0.3, 0.2, 3.5]), np.array([9.0, 8.0, 7.0]))
WALL = turned(quad("Wall", [[2, -2, 0.2], [2, 2, 0.2], [2, 2, 3.0], [2, -2, 3.0]]))


def waves(scale):
    return lambda x, y: five_sines(x, y, scale)


def solved(scene, method="caustic_map", side=64, **words):
    texels = [rasterise(receiver, side) for receiver in scene.receivers]
    return solve(scene, texels, Settings(method, surface="mesh", **words))


def difference(one, other):
    """Relative mean squared difference of the red of two Solutions."""
    a, b = (np.concatenate([i[..., 0].ravel() for i in s.images]) for s in (one, other))
    return ((a - b) ** 2).mean() / b.mean() ** 2


def balance(diagnostics):
    booked = sum(sum(books.values()) for books in (diagnostics.flux_received, diagnostics.flux_lost))
    return np.abs(booked / diagnostics.flux_in - 1).max()


def bent_rays(light, receivers, count=200, seed=5):
    """A Positions map of receivers, and rays that start 1.5 m over them, bent by up to 15 degrees off the light's."""
    rng = np.random.default_rng(seed)
    solids = Solids(receivers, ())
    corners = np.concatenate([r.positions for r in receivers]).T
    view = View(light, np.array([0.0, 0, -1]), np.concatenate([corners, [[0.0], [0], [4]]], 1))
    v = np.concatenate([rng.uniform(-0.4, 0.4, (2, count)), np.full((1, count), 1.5)])
    r = -view.towards(v)[0] + rng.uniform(-0.15, 0.15, (3, count))
    return Positions(view, solids, *view.bounds(corners), 256), v, r / np.linalg.norm(r, axis=0)


def bed(quads=40):
    x, y, triangles = grid(quads, 4.0)
    relief = 0.2 * np.sin(1.9 * x + 0.4) * np.cos(1.5 * y) + 0.05 * np.sin(4 * x - 2 * y)
    return Receiver("Bed", np.stack([x, y, relief], 1), triangles, (np.stack([x, y], 1) / 4 + 0.5)[triangles])


@pytest.mark.parametrize("direction", [(0.0, 0.0, -1.0), (0.25, 0.1, -1.0), (1.0, 0.3, -1.0)])
def test_the_iteration_converges_on_a_plane_as_its_factor_says(direction):
    light = sun(direction)
    positions, v, r = bent_rays(light, (floor(side=12.0),))
    true = -1.5 / r[2]
    factor = 1 - (r.T @ light.direction) * r[2] / light.direction[2]
    off = 0.02 * true
    for n in (0, 1, 2, 3):
        point, triangle = estimate(positions, v, r, n, true + off)
        assert (triangle >= 0).all()
        found = np.linalg.norm(point - v, axis=0)
        np.testing.assert_allclose(found - true, factor ** (n + 1) * off, atol=2e-2 * abs(factor).max() * off.max())
    point, _ = newton(positions, v, r, 1, true * 1.3)
    np.testing.assert_allclose(point, v + true * r, atol=1e-5)


@pytest.mark.parametrize("light", [sun(), LAMP])
def test_look_ups_on_an_uneven_bed_end_where_rays_do(light):
    """More iterations land nearer, and five as near as the map's cells tell."""
    receiver = bed()
    positions, v, r = bent_rays(light, (receiver,), seed=7)
    solids = Solids((receiver,), ())
    hit = solids.first(v, r)
    true = solids.meet(hit, v, r)[0]
    off = []
    for n in (1, 2, 3, 5):
        point, _ = estimate(positions, v, r, n, start(positions, v))
        off.append(np.sqrt(((point - true) ** 2).sum(0).mean()))
    assert off[0] > off[1] > off[2] and off[0] > 3 * off[3]
    assert off[3] < 1e-3


@pytest.mark.parametrize(
    "changes",
    [{}, {"direction": (1.0, 0.3, -1.0)}, {"receivers": [bed()]}, {"lights": (LAMP,)}, {"side": 3.6}],
    ids=["level", "low sun", "uneven", "lamp", "rim"],
)
def test_over_still_water_it_is_still_water(changes):
    words = {"side": 6.0, **changes}
    lights = words.pop("lights", None)
    scene = pool(flat, quads=8, **words)
    scene = replace(scene, lights=lights) if lights else scene
    true = solved(scene, "flat")
    answer = solved(scene, grid=256)
    assert difference(answer, true) < 4e-3
    np.testing.assert_allclose(answer.images[0].mean(), true.images[0].mean(), rtol=1e-2)
    assert balance(answer.diagnostics) < 1e-6


def test_mirrored_light_is_that_of_still_water_too():
    scene = pool(flat, quads=8, receivers=[WALL], side=12.0)
    answer, true = (solved(scene, method, **words) for method, words in (("caustic_map", {"grid": 384}), ("flat", {})))
    image, wanted = (s.images[0][34:62, 8:-8, 0] for s in (answer, true))
    np.testing.assert_allclose(image.mean(), wanted.mean(), rtol=2e-2)
    rows = image.reshape(7, 4, -1).mean((1, 2))  # splats lie apart along the wall, which the light grazes
    np.testing.assert_allclose(rows, wanted.mean(), rtol=0.15)


@pytest.mark.parametrize("changes", [{}, {"lights": (LAMP,)}, {"receivers": [bed()]}], ids=["sun", "lamp", "uneven"])
def test_gentle_waves_come_nearer_with_the_grid(changes):
    words = {"side": 6.0, **changes}
    lights = words.pop("lights", None)
    scene = pool(waves(0.3), quads=96, **words)
    scene = replace(scene, lights=lights) if lights else scene
    true = solved(scene, "photon_splat", tolerance=1e-5)
    errors = []
    for count in (64, 128, 256):
        answer = solved(scene, grid=count)
        errors.append(difference(answer, true))
        if count >= 128:
            assert errors[-1] / 2.5 < answer.diagnostics.estimated_error
    assert errors[0] > 2 * errors[1] > 4 * errors[2] and errors[2] < 5e-3


def test_grid_follows_the_tolerance():
    scene = pool(waves(0.1), quads=48)
    rough, fine = (solved(scene, side=32, tolerance=t).diagnostics for t in (0.3, 4e-3))
    assert rough.paths["splats"] < fine.paths["splats"] and fine.estimated_error <= 4e-3


def test_water_absorbs_and_disperses():
    scene = pool(waves(0.3), quads=48, side=6.0)
    murky = replace(scene, sigma_a=np.array([0.4, 0.1, 0.0]))
    answer, true = (solved(murky, method, side=32, grid=192) for method in ("caustic_map", "flat"))
    received = [s.diagnostics.flux_received["Floor"] for s in (answer, true)]
    np.testing.assert_allclose(*received, rtol=2e-2)
    coloured = solved(scene, side=32, grid=96, dispersion=20.0)
    for k, eta in enumerate(coloured.diagnostics.etas):
        alone = solved(replace(scene, eta=float(eta)), side=32, grid=96)
        np.testing.assert_allclose(coloured.images[0][..., k], alone.images[0][..., k], atol=1e-12)
    assert np.ptp(coloured.images[0], axis=2).max() > 0.01


def through(caster, light, count=64):
    """The light that passes a caster of glass: Seen and Bent."""
    shaded = Shaded([caster])
    view = View(light, np.array([0.0, 0, -1]), np.concatenate([shaded.positions.T, [[0.0], [0], [-1]]], 1))
    raster = Raster(*view.bounds(shaded.positions.T), count)
    seen = Seen(view, shaded, raster)
    _, passed = from_casters(seen, shaded, [caster], Backs(view, shaded, raster))
    return seen, passed


def test_a_slab_moves_light_aside_and_keeps_its_direction():
    light = sun((0.5, 0.0, -1.0))
    seen, bent = through(slab((-1, -1, 0), (1, 1, 0.3)), light)
    inner = (seen.facet[2] > 0.99) & (np.abs(seen.point[:2]).max(0) < 0.6)
    assert inner.sum() > 200
    np.testing.assert_allclose(bent.r[:, inner], np.repeat(light.direction[:, None], inner.sum(), 1), atol=1e-9)
    sin_i = np.hypot(*light.direction[:2])
    i, t = np.arcsin(sin_i), np.arcsin(sin_i / 1.5)
    way = t / i * 0.3 / np.cos(i) + (1 - t / i) * 0.3  # the source's guess of how far the light goes inside
    assert abs(way * np.cos(t) - 0.3) < 0.03 * 0.3
    np.testing.assert_allclose(bent.v[0, inner] - seen.point[0, inner], way * np.sin(t), atol=1e-6)
    np.testing.assert_allclose(bent.v[2, inner], 0.3 - way * np.cos(t), atol=1e-6)
    np.testing.assert_allclose(bent.flux[:, inner].sum(0) / 3 / seen.flux[inner], 0.919, atol=2e-3)


def test_a_ball_focuses_near_its_axis_where_the_lens_maker_says():
    """The back focal distance of a ball of index n and radius R is R (2 - n) / (2 (n - 1)) behind it."""
    seen, bent = through(ball(1.0, fine=128), sun((0.0, 0.0, -1.0)), 256)
    off = np.hypot(*seen.point[:2])
    near = (off < 0.15) & (off > 0.05)
    assert near.sum() > 100
    reach = -(seen.point[:2, near] * bent.v[:2, near]).sum(0) / (seen.point[:2, near] * bent.r[:2, near]).sum(0)
    focus = bent.v[2, near] + reach * bent.r[2, near]
    np.testing.assert_allclose(focus.mean(), -1.5, atol=0.05)


def test_glass_colours_and_metal_mirrors():
    colours = Glass(1.5, np.array([2.0, 0.2, 1.0]), np.ones(3), np.array([0.9, 1.0, 0.8]))
    scene = Scene(no_water(), (floor(),), (), (sun(),), casters=(ball(0.5, (0, 0, 0.8), material=colours, fine=24),))
    clear = replace(scene, casters=(replace(scene.casters[0], material=GLASS),))
    tinted, white = (solved(s, grid=64).images[0].sum((0, 1)) for s in (scene, clear))
    assert tinted[1] > tinted[2] > tinted[0] and (tinted < white).all()
    mirror = quad("Mirror", [[-0.5, -0.5, 2], [0.5, -0.5, 2], [0.5, 0.5, 2], [-0.5, 0.5, 2]])
    flat_mirror = replace(
        ball(fine=4),
        positions=mirror.positions,
        triangles=mirror.triangles,
        normals=np.tile([0.0, 0, 1], (4, 1)),
        normal_triangles=mirror.triangles,
        material=SILVER,
    )
    wall = turned(quad("Wall", [[2, -2, 0], [2, 2, 0], [2, 2, 6], [2, -2, 6]]))
    d = sun((1.0, 0.0, -1.0)).direction
    shining = Scene(no_water(), (wall,), (), (sun((1.0, 0.0, -1.0)),), casters=(flat_mirror,))
    answer = solved(shining, grid=128)
    np.testing.assert_allclose(answer.diagnostics.flux_received["Wall"], abs(d[2]), rtol=2e-2)
    image = answer.images[0][..., 0]
    centre = (image * np.arange(64)[:, None]).sum() / image.sum()
    np.testing.assert_allclose((centre + 0.5) * 6 / 64, 4.0, atol=0.1)  # 2 m up, and 2 m more on the way to the wall


def test_splats_keep_the_light_and_even_light_stays_even():
    x = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    bent = Receiver("L", np.column_stack([x, np.zeros(6)]), triangles, (x / 2.2 + 0.03)[triangles])
    for receiver in (floor(), bent):
        texels = rasterise(receiver, 48)
        rng = np.random.default_rng(0)
        light = np.stack([np.ones(len(texels.texel)), rng.random(len(texels.texel)) ** 8])
        out = splat(light, texels, np.full(texels.chart.max() + 1, 2.0))
        np.testing.assert_allclose(out @ texels.area, light @ texels.area, rtol=2e-3)
        np.testing.assert_allclose(out[0], 1, atol=3e-3)
        assert out[1].std() < 0.3 * light[1].std()


@pytest.mark.parametrize("words", [{"iterations": 0}, {"iterations": 6}, {"grid": -1}])
def test_impossible_settings_are_named(words):
    with pytest.raises(ValueError, match="iterations must be 1 to 5"):
        solved(pool(quads=4), **words)


def test_says_what_it_leaves_out():
    d = solved(pool(quads=16), grid=64).diagnostics
    assert d.method == "caustic_map" and "64" in d.reason and d.estimated_error > 0
    assert any("splat" in sentence for sentence in d.left_out)
    glass = Scene(no_water(), (floor(),), (), (sun(),), casters=(ball(0.5, (0, 0, 0.8), fine=12),))
    d = solved(glass, grid=32).diagnostics
    assert d.estimated_error is None and any("two surfaces" in sentence for sentence in d.left_out)
