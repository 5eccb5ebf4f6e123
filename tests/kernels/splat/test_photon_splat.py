"""Photons against closed forms, and their books."""

import numpy as np
import pytest
from waves import OBLIQUE, calm, five_sines, flat, floor, grid, pool, quad, sun, transmitted, turned, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Occluder, Receiver, Scene, Settings, Water
from dapple.kernels.splat import surroundings
from dapple.kernels.splat.photon_splat import solve
from dapple.kernels.splat.plane import one_plane
from dapple.kernels.status import Status

either = pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])


def bake(scene, resolution=64, tolerance=1e-3, seed=0, points=False):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=tolerance, seed=seed, points=points))


def books(diagnostics):
    received = sum(diagnostics.flux_received.values())
    return received + sum(diagnostics.flux_lost.values()), diagnostics.flux_in


def walls(height=1.5):
    """The four walls round the pool's floor, each with a quarter of the UV square to itself, as four receivers."""
    ends = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    return [
        turned(quad(f"Wall {k}", [[*a, 0], [*b, 0], [*b, height], [*a, height]]))
        for k, (a, b) in enumerate(zip(ends, np.roll(ends, -1, axis=0), strict=True))
    ]


@pytest.mark.parametrize("degrees", [0.0, 10.0, 30.0, 45.0])
@pytest.mark.parametrize("depth", [0.3, 1.5])
@either
def test_flat_water_is_fresnel_times_cosine(degrees, depth, points):
    angle = np.radians(degrees)
    scene = pool(
        flat, quads=24, direction=(np.sin(angle), 0, -np.cos(angle)), side=12.0, receivers=[floor(z=1.5 - depth)]
    )
    image = bake(scene, 32, tolerance=1e-4, points=points).images[0]
    expected = np.cos(angle) * transmitted(np.cos(angle))
    assert image.mean() == pytest.approx(expected, rel=5e-3 if points else 3e-4)
    np.testing.assert_allclose(image, expected, rtol=0.05 if points else 0.02)
    if not points:
        np.testing.assert_allclose(image[2:-2, 2:-2], expected, rtol=1e-9)


@either
def test_energy_all_that_enters_is_received_or_booked_as_lost(points):
    """Under a floor far wider than the water, what the lit area passes by Fresnel's formula all arrives."""
    scene = pool(flat, quads=16, side=2.0, receivers=[floor(side=12.0)])
    d = bake(scene, points=points).diagnostics
    cos_i = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
    np.testing.assert_allclose(d.flux_in, 4.0 * cos_i, rtol=1e-12)
    np.testing.assert_allclose(d.flux_received["Floor"], 4.0 * cos_i * transmitted(cos_i), rtol=1e-9)
    np.testing.assert_allclose(d.flux_lost["reflected"], 4.0 * cos_i * (1 - transmitted(cos_i)), rtol=1e-9)
    assert d.flux_lost["missed"][0] == 0
    np.testing.assert_allclose(*books(d), rtol=1e-9)


@either
def test_a_closed_pool_receives_all_that_enters(points):
    """Walls and floor close the water in: nothing is missed, and the books close within rounding."""
    scene = pool(quads=48, side=4.0, receivers=[floor(), *walls(height=2.0)])
    d = bake(scene, 64, tolerance=1e-2, points=points).diagnostics
    total, entering = books(d)
    np.testing.assert_allclose(total, entering, rtol=2e-3)
    assert d.flux_lost["missed"][0] < 2e-3 * entering[0]
    assert all(flux[0] >= 0 for flux in d.flux_received.values()) and d.flux_received["Wall 1"][0] > 0


@either
def test_mean_of_the_pool_is_known(points):
    image = bake(pool(quads=128), 128, tolerance=1e-2, points=points).images[0]
    assert image.mean() == pytest.approx(0.944, abs=2e-3)


def test_rays_and_the_plane_land_photons_alike(monkeypatch):
    scene = pool(quads=32)
    by_plane = bake(scene, 64, tolerance=1e-2, points=True)
    monkeypatch.setattr(surroundings, "one_plane", lambda *_: None)
    by_rays = bake(scene, 64, tolerance=1e-2, points=True)
    # The same photons: only those within float32's rounding of a texel's border may differ.
    difference = np.abs(by_plane.images[0] - by_rays.images[0])[..., 0]
    assert (difference > 1e-9).mean() < 0.2
    assert difference.sum() < 1e-3 * by_plane.images[0][..., 0].sum()
    np.testing.assert_allclose(
        by_plane.diagnostics.flux_received["Floor"], by_rays.diagnostics.flux_received["Floor"], rtol=1e-5
    )


def test_the_plane_is_taken_only_where_it_is_right():
    direct = [rasterise(floor(), 32)]
    assert one_plane(pool(quads=4), direct) is not None
    hung = pool(quads=4, occluders=[Occluder("Raft", floor(z=0.5).positions, floor().triangles)])
    assert one_plane(hung, direct) is None
    inset = floor(uv_low=(0.1, 0.1), uv_high=(0.87, 0.87))
    assert one_plane(pool(quads=4, receivers=[inset]), [rasterise(inset, 32)]) is None
    bent = floor()
    bent.positions[2, 2] = 0.2
    assert one_plane(pool(quads=4, receivers=[bent]), [rasterise(bent, 32)]) is None


@pytest.mark.parametrize("direction", [OBLIQUE, (0, 0, -1), (0.9, -0.4, -1)])
def test_beams_by_rays_and_by_the_plane_give_one_picture(monkeypatch, direction):
    scene = pool(quads=48, direction=direction)
    by_plane = bake(scene, 64, tolerance=1e-5)
    monkeypatch.setattr(surroundings, "one_plane", lambda *_: None)
    by_rays = bake(scene, 64, tolerance=1e-5)
    difference = ((by_plane.images[0] - by_rays.images[0]) ** 2).mean() / by_rays.images[0].mean() ** 2
    assert difference < 3e-5
    for cause, watts in by_plane.diagnostics.flux_lost.items():
        np.testing.assert_allclose(
            by_rays.diagnostics.flux_lost[cause], watts, atol=1e-4 * by_rays.diagnostics.flux_in[0]
        )


@pytest.mark.parametrize("z", [1.9, 0.7])
@either
def test_occluders_cast_a_sharp_shadow_of_the_right_size(z, points):
    raft = floor(side=1.0, z=z)
    scene = pool(flat, quads=64, side=12.0, occluders=[Occluder("Raft", raft.positions, raft.triangles)])
    answer = bake(scene, points=points)
    image = answer.images[0][..., 0]
    clear = 0.9625 * np.max(image)
    dark = image < 0.5 * clear
    assert dark.sum() / 64**2 * 16 == pytest.approx(1.0, abs=0.07)
    cause = "shadowed" if z > 1.5 else "occluded"
    cos_i = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
    expected = cos_i * (1.0 if z > 1.5 else transmitted(cos_i))
    assert answer.diagnostics.flux_lost[cause][0] == pytest.approx(expected, rel=5e-3)


@either
def test_seams_no_light_is_lost_between_two_halves_of_a_floor(points):
    """A floor in two charts that do not fit the texels receives what the whole floor does, and shows no edge."""
    left = quad("Left", [[-2, -2, 0], [0, -2, 0], [0, 2, 0], [-2, 2, 0]], (0.113, 0.027), (0.467, 0.731))
    right = quad("Right", [[0, -2, 0], [2, -2, 0], [2, 2, 0], [0, 2, 0]], (0.113, 0.027), (0.467, 0.731))
    halves = bake(pool(flat, quads=24, side=8.0, receivers=[left, right]), 64, tolerance=1e-4, points=points)
    cos_i = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
    expected = cos_i * transmitted(cos_i)
    for name, image, status in zip(("Left", "Right"), halves.images, halves.status, strict=True):
        assert halves.diagnostics.flux_received[name][0] == pytest.approx(8.0 * expected, rel=1e-4)
        lit = status == Status.LIT
        # Border texels as bright as the others: nothing doubled, nothing missing.
        off = np.abs(image[..., 0][lit] / expected - 1)
        assert lit.sum() > 900
        if points:
            assert (off < 0.08).all()
        else:  # but for the chart's four corners, where more than two sides meet, right to a few thousandths
            assert (off > 5e-3).sum() <= 4 and off.max() < 0.25


def test_two_suns_add_in_colour():
    red, blue = sun(OBLIQUE, (2.0, 0.0, 0.0)), sun((-0.2, 0.3, -1), (0.0, 0.0, 3.0))
    w, f = water(five_sines, 24), floor()
    both = bake(Scene(w, (f,), (), (red, blue)), 32)
    one = bake(Scene(w, (f,), (), (red,)), 32)
    other = bake(Scene(w, (f,), (), (blue,)), 32)
    np.testing.assert_allclose(both.diagnostics.flux_in, one.diagnostics.flux_in + other.diagnostics.flux_in)
    assert both.images[0][..., 1].max() == 0
    assert both.images[0][..., 0].mean() == pytest.approx(one.images[0][..., 0].mean(), rel=1e-3)
    assert both.images[0][..., 2].mean() == pytest.approx(other.images[0][..., 2].mean(), rel=1e-3)


def test_winding_and_direction_of_normals_do_not_matter():
    scene = pool(quads=24, receivers=[floor(side=12.0)])
    w = scene.water
    turned = np.ascontiguousarray(w.triangles[:, ::-1])
    upside_down = Water(w.name, w.positions, turned, -w.normals, turned, build_twins(turned))
    scene_turned = Scene(upside_down, scene.receivers, (), scene.lights)
    a, b = bake(scene, 16, 1e-2), bake(scene_turned, 16, 1e-2)
    np.testing.assert_allclose(a.diagnostics.flux_received["Floor"], b.diagnostics.flux_received["Floor"], rtol=1e-4)


def test_the_estimate_of_points_tells_their_error():
    scene = pool(quads=48)
    reference = np.mean([bake(scene, 64, 1e-4, seed, points=True).images[0] for seed in range(100, 104)], axis=0)
    for tolerance in (1e-1, 1e-2, 1e-3):
        answer = bake(scene, 64, tolerance, seed=1, points=True)
        true = ((answer.images[0] - reference) ** 2).mean() / reference.mean() ** 2
        assert answer.diagnostics.estimated_error <= tolerance
        assert 0.5 < answer.diagnostics.estimated_error / true < 2


def test_a_seed_gives_one_picture():
    scene = pool(quads=16)
    a, b, c = (bake(scene, 16, 1e-2, seed, points=True).images[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


@either
def test_water_without_triangles_lights_nothing(points):
    empty = np.zeros((0, 3), int)
    dry = Water("Dry", water(flat, 2).positions, empty, np.zeros((0, 3)), empty, np.zeros(0, int))
    answer = bake(Scene(dry, (floor(),), (), (sun(),)), 8, points=points)
    assert (answer.status[0] == Status.DARK).all() and not answer.images[0].any()


@pytest.mark.parametrize("quads", [24, 64, 192])
def test_beams_equal_many_points(quads):
    """Independent sums of one integral: beams lie within the error that the points know of themselves."""
    scene = pool(quads=quads)
    beams = bake(scene, 64, 1e-4)
    points = bake(scene, 64, 1e-4, points=True)
    difference = ((beams.images[0] - points.images[0]) ** 2).mean() / points.images[0].mean() ** 2
    assert difference < 2 * (points.diagnostics.estimated_error + beams.diagnostics.estimated_error)
    for cause, watts in points.diagnostics.flux_lost.items():
        np.testing.assert_allclose(beams.diagnostics.flux_lost[cause], watts, rtol=2e-3, atol=1e-3)


@pytest.mark.parametrize("shape", [calm, five_sines], ids=["calm", "five_sines"])
def test_the_estimate_of_beams_is_of_the_right_size(shape):
    """The error against beams a hundred times finer, on a floor and on steep walls, within a factor of ten."""
    scene = pool(shape, quads=48, side=4.0, receivers=[floor(), *walls(height=2.0)])
    fine = bake(scene, 64, 1e-9).images
    answer = bake(scene, 64, 1e-2)
    error = sum(((a - b) ** 2).sum() for a, b in zip(answer.images, fine, strict=True))
    true = error / sum(b.size for b in fine) / np.mean(np.concatenate(fine)) ** 2
    assert true < 10 * answer.diagnostics.estimated_error


def test_beams_on_a_bed_that_is_not_flat():
    """Uneven ground in one chart: beams against points, and not a watt more or less."""
    x, y, triangles = grid(40, 5.0)
    bed = np.stack([x, y, 0.3 * np.sin(2 * x) * np.cos(3 * y)], 1)
    receiver = Receiver("Bed", bed, triangles, (np.stack([x, y], 1) / 5 + 0.5)[triangles])
    scene = pool(quads=64, receivers=[receiver])
    beams, points = bake(scene, 64, 1e-3), bake(scene, 64, 1e-3, points=True)
    difference = ((beams.images[0] - points.images[0]) ** 2).mean() / points.images[0].mean() ** 2
    assert difference < 2 * points.diagnostics.estimated_error + beams.diagnostics.estimated_error
    np.testing.assert_allclose(*books(beams.diagnostics), rtol=1e-9)
    np.testing.assert_allclose(
        beams.diagnostics.flux_received["Bed"], points.diagnostics.flux_received["Bed"], rtol=1e-3
    )


def test_facets_bend_light_as_planes():
    """Flat shading: every facet moves its light as one piece, and the energy is all there."""
    scene = pool(quads=24, receivers=[floor(side=12.0)])
    w = scene.water
    v = w.positions[w.triangles]
    facet = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(facet))[:, None], 3, 1)
    facets = Scene(Water("Facets", w.positions, w.triangles, facet, rows, w.twins), scene.receivers, (), scene.lights)
    beams, points = bake(facets, 32, 1e-3), bake(facets, 32, 1e-3, points=True)
    np.testing.assert_allclose(*books(beams.diagnostics), rtol=1e-9)
    np.testing.assert_allclose(
        beams.diagnostics.flux_received["Floor"], points.diagnostics.flux_received["Floor"], rtol=1e-5
    )
    lost, expected = beams.diagnostics.flux_lost["reflected"], points.diagnostics.flux_lost["reflected"]
    np.testing.assert_allclose(lost, expected, rtol=1e-5)


def test_a_static_scene_gives_the_same_bits():
    scene = pool(quads=24)
    np.testing.assert_array_equal(bake(scene, 32).images[0], bake(scene, 32).images[0])


def test_dark_texels_are_dark_and_none_is_negative():
    """A raft hides a part of the floor: what rounding leaves there is no light."""
    raft = floor(side=2.0, z=0.1)
    scene = pool(quads=48, occluders=[Occluder("Raft", raft.positions, raft.triangles)])
    answer = bake(scene)
    image, status = answer.images[0], answer.status[0]
    assert (image >= 0).all()
    assert (image[status == Status.DARK] == 0).all() and (status == Status.DARK).sum() > 0.8 * 64**2 / 4


@either
def test_a_wall_exactly_along_still_light_takes_none(points):
    """Overhead sun, still water, an upright wall: rays slide along its face, which is no error and no light."""
    wall = quad("Wall", [[-1, 0, 0], [1, 0, 0], [1, 0, 1.4], [-1, 0, 1.4]])
    scene = pool(flat, quads=8, direction=(0, 0, -1), receivers=[floor(), wall])
    with np.errstate(all="raise"):
        answer = bake(scene, 32, 1e-2, points=points)
    assert all(np.isfinite(image).all() for image in answer.images)
    assert answer.diagnostics.flux_received["Wall"][0] < 1e-2 * answer.diagnostics.flux_received["Floor"][0]
    np.testing.assert_allclose(*books(answer.diagnostics), rtol=1e-9)


@pytest.mark.parametrize("what", ["post", "wall along the light", "rope above"])
def test_thin_things_between_the_rays_are_seen(what):
    """Narrower than the water's triangles are apart, or seen on edge: beams against points, which see everything."""
    wall = quad("Wall", [[-1.5, 0.11, 0], [1.5, 0.11, 0], [1.5, 0.11, 1.2], [-1.5, 0.11, 1.2]])
    post = quad("Post", [[0.2, -0.5, 0], [0.2, -0.46, 0], [0.2, -0.46, 1.2], [0.2, -0.5, 1.2]])
    rope = quad("Rope", [[-2, -1, 1.9], [2, 1, 2.2], [2, 1.02, 2.2], [-2, -0.98, 1.9]])
    extra = {"post": post, "wall along the light": wall}.get(what)
    occluders = [Occluder("Rope", rope.positions, rope.triangles)] if extra is None else []
    receivers = [floor()] if extra is None else [floor(), extra]
    scene = pool(quads=48, direction=(1.0, 0, -2), receivers=receivers, occluders=occluders)
    beams, points = (
        bake(scene, 128, tolerance, points=p).diagnostics for p, tolerance in ((False, 1e-3), (True, 1e-2))
    )
    if extra is None:
        assert beams.flux_lost["shadowed"][0] == pytest.approx(points.flux_lost["shadowed"][0], rel=0.1)
    else:
        assert beams.flux_received[extra.name][0] == pytest.approx(points.flux_received[extra.name][0], rel=0.05)
