"""Point and spot lamps against closed forms, against the points' independent sums, and their books."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, flat, floor, mesh_water, quad, transmitted, turned, water

from dapple.kernels.lit_water import light_water, may_be_shadowed
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.rays import Tracer
from dapple.kernels.scene import Occluder, Point, Scene, Settings, Spot
from dapple.kernels.splat.photon_splat import solve

either = pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])
NO_BEND = 1.0001  # eta of water that hardly bends: what is left is the lamp's own light
LAMP = np.array([0.3, -0.2, 3.5])


def lamp(position=LAMP, intensity=(1.0, 1.0, 1.0)):
    return Point("Lamp", np.asarray(position, float), np.asarray(intensity, float))


def spot(position=LAMP, towards=(0.0, 0.0, 0.0), degrees=25.0, blend=0.0, stretch=(1.0, 1.0)):
    """A Spot aimed at a point."""
    axis = np.subtract(towards, position) / np.linalg.norm(np.subtract(towards, position))
    across = np.cross([0.0, 1.0, 0.0], axis)
    across /= np.linalg.norm(across)
    frame = np.stack([across / stretch[0], np.cross(axis, across) / stretch[1], axis])
    return Spot("Spot", np.asarray(position, float), np.ones(3), 0.0, frame, np.radians(degrees), blend)


def bake(scene, resolution=64, tolerance=1e-4, points=False):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=tolerance, points=points))


def under(light, shape=flat, quads=24, eta=1.333, receivers=(), occluders=(), side=4.8):
    return Scene(water(shape, quads, side), tuple(receivers) or (floor(),), tuple(occluders), (light,), eta)


def centres(resolution, side=4.0):
    axis = (np.arange(resolution) + 0.5) * side / resolution - side / 2
    return np.meshgrid(axis, axis)


def texel_means(function, resolution, side=4.0, fine=4):
    """Means of function(x, y) over the texels of a square floor."""
    return function(*centres(resolution * fine, side)).reshape(resolution, fine, resolution, fine).mean((1, 3))


def through_flat_water(radius, above, depth, eta=1.333):
    """E on a level floor for 1 W/sr, `radius` from below a lamp `above` m over flat water: Snell by bisection, and the
    flux of a ring of directions over the area of the ring that it lights."""
    low, high = np.zeros_like(radius), np.full_like(radius, np.pi / 2 - 1e-9)
    for _ in range(60):
        i = (low + high) / 2
        t = np.arcsin(np.sin(i) / eta)
        short = above * np.tan(i) + depth * np.tan(t) < radius
        low, high = np.where(short, i, low), np.where(short, high, i)
    slope = above / np.cos(i) ** 2 + depth / np.cos(t) ** 2 * np.cos(i) / (eta * np.cos(t))
    share = np.vectorize(transmitted)(np.cos(i))
    return share * np.sin(i) / (radius * slope)


def solid_angle(soup, position):
    """Sum of the solid angles [sr] of triangles (T,3,3), after Van Oosterom & Strackee 1983."""
    a, b, c = (soup[:, k] - position for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    dots = la * lb * lc + (a * b).sum(1) * lc + (a * c).sum(1) * lb + (b * c).sum(1) * la
    return 2 * np.arctan2(np.abs((a * np.cross(b, c)).sum(1)), dots).sum()


@pytest.mark.parametrize("above", [0.4, 2.0])
@pytest.mark.parametrize("quads", [8, 64])
def test_flat_water_under_a_point_lamp(above, quads):
    """Water coarser and finer than the texels, a lamp nearer and further than the water is deep."""
    light = lamp((0.3, -0.2, 1.5 + above))
    image = bake(under(light, quads=quads), tolerance=1e-5).images[0][..., 0]
    expected = texel_means(lambda x, y: through_flat_water(np.hypot(x - 0.3, y + 0.2), above, 1.5), 64)
    assert ((image - expected) ** 2).mean() < 1e-5 * expected.mean() ** 2
    assert np.abs(image - expected).max() < 0.05 * expected.mean()
    assert image.mean() == pytest.approx(expected.mean(), rel=2e-4)


@either
def test_water_that_does_not_bend_leaves_the_inverse_square(points):
    image = bake(under(lamp(), eta=NO_BEND), points=points).images[0][..., 0]
    expected = texel_means(lambda x, y: 3.5 / ((x - 0.3) ** 2 + (y + 0.2) ** 2 + 3.5**2) ** 1.5, 64)
    np.testing.assert_allclose(image.mean(), expected.mean(), rtol=1e-3)
    assert ((image - expected) ** 2).mean() < 3e-4 * expected.mean() ** 2


@pytest.mark.parametrize("above", [0.4, 2.0])
@either
def test_what_meets_the_water_is_the_solid_angle_that_it_fills(above, points):
    """And all of it is booked: received, reflected or missed."""
    light = lamp((0.3, -0.2, 1.5 + above), (1.0, 2.0, 0.5))
    scene = under(light, five_sines, quads=32, receivers=[floor(side=3.0)])
    d = bake(scene, 32, 1e-3, points).diagnostics
    expected = solid_angle(scene.water.positions[scene.water.triangles], light.position)
    np.testing.assert_allclose(d.flux_in, expected * light.intensity, rtol=5e-3 if points else 1e-3)
    total = d.flux_received["Floor"] + sum(d.flux_lost.values())
    np.testing.assert_allclose(total, d.flux_in, rtol=1e-9)
    assert d.flux_lost["missed"][0] > 0


@pytest.mark.parametrize("blend", [0.0, 0.15, 1.0])
@pytest.mark.parametrize("stretch", [(1.0, 1.0), (1.6, 0.7)])
def test_the_cone_of_a_spot_and_its_blend(blend, stretch):
    """Through water that does not bend: Blender's smoothstep in the cosine, and no blend is a sharp edge."""
    light = spot(degrees=20.0, blend=blend, stretch=stretch)
    image = bake(under(light, eta=NO_BEND), tolerance=2e-5).images[0][..., 0]

    def expected(x, y):
        way = np.stack([x, y, np.zeros_like(x)]) - LAMP[:, None, None]
        distance = np.linalg.norm(way, axis=0)
        local = np.einsum("ij,jkl->ikl", light.frame, way)
        depth = local[2] / np.linalg.norm(local, axis=0) - np.cos(np.radians(20.0))
        ramp = np.clip(depth / max(blend * (1 - np.cos(np.radians(20.0))), 1e-9), 0, 1)
        return ramp**2 * (3 - 2 * ramp) * 3.5 / distance**3

    expected = texel_means(expected, 64, fine=16)
    assert image.mean() == pytest.approx(expected.mean(), rel=2e-3)
    assert ((image - expected) ** 2).mean() < 2e-4 * (expected**2).mean()
    assert (image[expected == 0] < 1e-3 * expected.max()).mean() > 0.98


@either
def test_points_and_beams_agree_under_a_spot_over_waves(points):
    """On floor and walls, cone and blend included."""
    wall = turned(quad("Wall", [[1.5, -2, 0], [1.5, 2, 0], [1.5, 2, 1.3], [1.5, -2, 1.3]]))
    scene = under(spot(towards=(0.8, 0.0, 0.0), degrees=30.0, blend=0.5), five_sines, 48, receivers=[floor(), wall])
    beams, other = bake(scene, 32, 1e-3), bake(scene, 32, 1e-3, points)
    assert beams.diagnostics.flux_received["Wall"][0] > 0.01
    for name, watts in beams.diagnostics.flux_received.items():
        np.testing.assert_allclose(other.diagnostics.flux_received[name], watts, rtol=1e-2)
    difference = ((beams.images[0] - other.images[0]) ** 2).mean() / beams.images[0].mean() ** 2
    assert difference < 2 * (beams.diagnostics.estimated_error + other.diagnostics.estimated_error)


@pytest.mark.parametrize("z", [2.5, 0.7])
def test_a_raft_casts_the_shadow_that_the_lamp_makes_wider(z):
    """A raft of 0.6 m between lamp and water, and one below it; room walls that reach past the lamp block nothing."""
    raft = floor(side=0.6, z=z)
    wall = quad("Room", [[3, -3, 1.6], [3, 3, 1.6], [3, 3, 9], [3, -3, 9]])
    solids = [Occluder("Raft", raft.positions, raft.triangles), Occluder("Room", wall.positions, wall.triangles)]
    answer = bake(under(lamp((0.0, 0.0, 3.5)), eta=NO_BEND, quads=48, occluders=solids))
    image = answer.images[0][..., 0]
    clear = bake(under(lamp((0.0, 0.0, 3.5)), eta=NO_BEND, quads=48)).images[0][..., 0]
    shadow = (1 - image / clear).sum() * (4 / 64) ** 2
    assert shadow == pytest.approx((0.6 * 3.5 / (3.5 - z)) ** 2, rel=0.03)
    cause = "shadowed" if z > 1.5 else "occluded"
    up = (raft.positions - [0.0, 0.0, 3.5])[raft.triangles]
    assert answer.diagnostics.flux_lost[cause][0] == pytest.approx(solid_angle(up, np.zeros(3)), rel=0.01)


def test_water_turned_the_other_way_is_the_same_water():
    scene = under(lamp(), five_sines, 24)
    w = scene.water
    flipped = replace(scene, water=mesh_water(w.positions, w.triangles[:, ::-1], -w.normals))
    other, image = bake(flipped).images[0], bake(scene).images[0]
    assert ((other - image) ** 2).mean() < 1e-8 * image.mean() ** 2


def test_lamps_and_colours_add():
    both = (lamp(intensity=(1.0, 0.0, 0.0)), spot(blend=0.3))
    scene = under(both[0])
    whole = Scene(scene.water, scene.receivers, (), both)
    parts = [bake(Scene(scene.water, scene.receivers, (), (one,))).images[0] for one in both]
    np.testing.assert_allclose(bake(whole).images[0], parts[0] + parts[1], atol=1e-12)
    assert not parts[0][..., 1:].any()


def test_a_wall_above_still_water_sees_the_lamp_mirrored_in_it():
    """E = I (1 - T) cos / R^2 from the mirror image, below the surface as far as the lamp is above it."""
    wall = turned(quad("Wall", [[1.5, -1, 1.6], [1.5, 1, 1.6], [1.5, 1, 2.6], [1.5, -1, 2.6]]))
    answer = bake(under(lamp((0.2, 0.1, 3.0)), quads=64, receivers=[wall]))
    image = answer.images[0][..., 0]
    y, z = np.meshgrid(np.linspace(-1, 1, 129)[1::2], np.linspace(1.6, 2.6, 129)[1::2])
    way = np.stack([np.full_like(y, 1.3), y - 0.1, z])  # from (0.2, 0.1, 0), the image of the lamp in z = 1.5
    distance = np.linalg.norm(way, axis=0)
    expected = (1 - np.vectorize(transmitted)(way[2] / distance)) * way[0] / distance**3
    assert image.mean() == pytest.approx(expected.mean(), rel=1e-3)
    error = ((image - expected) ** 2).mean() / expected.mean() ** 2
    assert error < min(1e-3, answer.diagnostics.estimated_error)


@pytest.mark.parametrize("seed", range(4))
def test_no_shadow_of_a_lamp_is_missed(seed):
    """A ball of triangles near the lamp, one that reaches behind it too: water that it hides must be marked."""
    rng = np.random.default_rng(seed)
    light = lamp((0.4, -0.3, 2.6))
    centre = light.position + np.array([0.2, 0.1, -0.5 * rng.random()])
    positions = centre + rng.normal(size=(60, 3)) * 0.15
    triangles = rng.integers(0, 60, (60, 3))
    w = water(five_sines, 48)
    lit = light_water(w, light)
    marked = may_be_shadowed(lit, positions, triangles)
    weights = rng.dirichlet([1, 1, 1], (len(w.triangles), 4))
    points = np.einsum("tsk,tkx->tsx", weights, w.positions[w.triangles]).reshape(-1, 3)
    towards, distance, _ = lit.source.incident(points.T)
    blocked = Tracer(positions, triangles).blocked(points, towards.T, distance).reshape(-1, 4).any(1)
    assert blocked.sum() > 20
    assert not (blocked & ~marked).any()


def test_a_lamp_below_all_objects_is_shadowed_by_none():
    lit = light_water(water(five_sines, 24), lamp((0.0, 0.0, 2.0)))
    ceiling, bed = floor(side=9.0, z=3.0), floor(side=9.0)
    for solid in (ceiling, bed):
        assert not may_be_shadowed(lit, solid.positions, solid.triangles).any()
