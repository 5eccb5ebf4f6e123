"""Area lamps against closed forms, against sums of many points of them, and their books."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball, no_water, slab
from waves import calm, five_sines, flat, floor, pool, transmitted, water

from dapple.kernels.area_lamps import among, cut, lamp_of, pieces
from dapple.kernels.disc.disc import within_disc
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, prepare, solve
from dapple.kernels.scene import Area, Point, Scene, Settings
from dapple.kernels.sources import falloff
from dapple.kernels.splat import photon_splat

NO_BEND = 1.0001  # eta of water that hardly bends: what is left is the lamp's own light
HIGH = np.array([0.3, -0.2, 3.5])


def panel(half=(0.5, 0.5), position=HIGH, radiance=1.0, **settings):
    """An Area of even radiance [W/m^2/sr] that looks down."""
    half_axes = np.array([[half[0], 0.0, 0.0], [0.0, -half[1], 0.0]])
    surface = half[0] * half[1] * (np.pi if settings.get("round") else 4)
    return Area("Panel", np.asarray(position, float), np.full(3, radiance * surface), half_axes=half_axes, **settings)


def under(light, shape=flat, quads=24, eta=NO_BEND, receivers=(), side=8.0):
    return Scene(water(shape, quads, side), tuple(receivers) or (floor(),), (), (light,), eta)


def bake(scene, resolution=32, **settings):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(**{"tolerance": 1e-4, "method": "photon_splat", **settings}))


def centres(resolution, side=4.0):
    axis = (np.arange(resolution) + 0.5) * side / resolution - side / 2
    return np.meshgrid(axis, axis)


def from_rectangle(x, y, area):
    """E on a level plane of a level rectangle of radiance 1, by the form factor of a corner [Howell, B-3]."""
    half, height = np.abs(np.diag(area.half_axes)), area.position[2]

    def corner(a, b):
        a, b = a / height, b / height
        one, two = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / one * np.arctan(b / one) + b / two * np.arctan(a / two)) / 2

    ends = [[p - area.position[k] + sign * half[k] for sign in (1, -1)] for k, p in enumerate((x, y))]
    return corner(ends[0][0], ends[1][0]) - corner(ends[0][1], ends[1][0]) - corner(ends[0][0], ends[1][1]) + corner(
        ends[0][1], ends[1][1]
    )  # fmt: skip


def off(image, expected):
    return ((image - expected) ** 2).mean() / (expected**2).mean()


def test_a_rectangle_has_the_form_factor_of_a_rectangle():
    light = panel((0.8, 0.3))
    image = bake(under(light), 16, tolerance=1e-3, surface="mesh").images[0][..., 1]
    expected = from_rectangle(*centres(16), light)
    assert image.mean() == pytest.approx(expected.mean(), rel=5e-3)
    assert off(image, expected) < 3e-4


@pytest.mark.parametrize("radius", [0.1, 0.7])
def test_under_the_middle_of_a_disc_it_is_the_sine_squared(radius):
    light = panel((radius, radius), (0.0, 0.0, 2.5), round=True)
    scene = under(light, receivers=[floor(side=1.0)])
    image = bake(scene, 9, tolerance=1e-3, surface="mesh").images[0][4, 4, 0]
    np.testing.assert_allclose(image, np.pi * radius**2 / (radius**2 + 2.5**2), rtol=1.5e-2)


def through_still_water(x, y, area, depth=1.5, eta=1.333, many=12):
    """E on a level floor: Snell by bisection for each of many points of a rectangle, with the cosine of the lamp."""
    total = 0.0
    for piece in pieces(area, (many, many)):
        above = area.position[2] - depth
        radius = np.maximum(np.hypot(x - piece.position[0], y - piece.position[1]), 1e-6)
        low, high = np.zeros_like(radius), np.full_like(radius, np.pi / 2 - 1e-9)
        for _ in range(50):
            i = (low + high) / 2
            short = above * np.tan(i) + depth * np.tan(np.arcsin(np.sin(i) / eta)) < radius
            low, high = np.where(short, i, low), np.where(short, high, i)
        t = np.arcsin(np.sin(i) / eta)
        slope = above / np.cos(i) ** 2 + depth / np.cos(t) ** 2 * np.cos(i) / (eta * np.cos(t))
        passed = np.vectorize(transmitted)(np.cos(i))
        total = total + piece.intensity[0] * np.cos(i) * passed * np.sin(i) / (radius * slope)
    return total


@pytest.mark.parametrize("method", ["photon_splat", "conic_walk", "flat", "caustic_map"])
def test_every_method_brings_its_light_through_still_water(method):
    light = panel((0.6, 0.4))
    scene = under(light, eta=1.333)
    answer = bake(scene, 24, tolerance=1e-3, method=method)
    expected = through_still_water(*centres(24), light)
    assert answer.images[0][..., 0].mean() == pytest.approx(expected.mean(), rel=1e-2)
    assert off(answer.images[0][..., 0], expected) < 2e-3
    assert not any("Panel" in sentence for sentence in answer.diagnostics.left_out)


def by_points(scene, light, many, resolution, tolerance=3e-2):
    """What many points of a lamp bring together."""
    total, texels, settings = 0.0, [rasterise(r, resolution) for r in scene.receivers], Settings(tolerance=tolerance)
    for piece in pieces(light, (many, many)):
        point = replace(piece, half_axes=np.zeros((2, 3)), among=1)
        total = total + photon_splat.solve(replace(scene, lights=(point,)), texels, settings).images[0]
    return total


@pytest.fixture(scope="module")
def storm():
    """Waves under a wide lamp, and what 100 points of it bring."""
    light = panel((0.25, 0.4), radiance=2.0)
    scene = under(light, five_sines, 32, 1.333, side=4.8)
    return scene, by_points(scene, light, 10, 32)


@pytest.mark.parametrize("tolerance", [3e-2, 1e-3])
def test_over_waves_pieces_with_their_blur_are_as_good_as_asked(storm, tolerance):
    scene, expected = storm
    answer = bake(scene, 32, tolerance=tolerance, surface="mesh")
    error = off(answer.images[0], expected)
    assert error < tolerance
    assert error < 3 * answer.diagnostics.estimated_error + 3e-4
    np.testing.assert_allclose(answer.images[0].mean(), expected.mean(), rtol=1e-2)


def test_as_many_points_without_the_blur_are_much_worse(storm):
    """Four points make four pictures of the waves beside each other, which no lamp of a size does."""
    scene, expected = storm
    made = replace(scene, lights=tuple(pieces(scene.lights[0], (2, 2))))
    with_blur = photon_splat.solve(made, [rasterise(scene.receivers[0], 32)], Settings(tolerance=1e-3)).images[0]
    assert off(by_points(scene, scene.lights[0], 2, 32), expected) > 5 * off(with_blur, expected)


def test_points_and_beams_agree(storm):
    scene, expected = storm
    answer = bake(scene, 32, tolerance=1e-2, surface="mesh", points=True)
    assert off(answer.images[0], expected) < 2 * answer.diagnostics.estimated_error + 1e-3


def test_the_books_close():
    scene = under(panel((0.5, 0.3), radiance=3.0), five_sines, 32, 1.333, [floor(side=3.0)], 4.8)
    d = bake(scene, 32, tolerance=1e-3).diagnostics
    np.testing.assert_allclose(d.flux_received["Floor"] + sum(d.flux_lost.values()), d.flux_in, rtol=1e-9)
    fine = pieces(scene.lights[0], (8, 8))
    x, y = centres(200, 4.8)
    met = sum(
        p.intensity[0] * (2.0**2 / ((x - p.position[0]) ** 2 + (y - p.position[1]) ** 2 + 2.0**2) ** 2) for p in fine
    )
    np.testing.assert_allclose(d.flux_in[0], met.sum() * (4.8 / 200) ** 2, rtol=1e-2)


@pytest.mark.parametrize("degrees", [30, 90, 150, 180])
def test_slats_narrow_the_light_and_keep_its_watts(degrees):
    """All that leaves the lamp: pi watts for 1 W/sr along its axis without slats, whatever the spread."""
    lamp = pieces(panel((0.1, 0.1), spread=np.radians(degrees)), (1, 1))[0]
    cosine = (np.arange(200_000) + 0.5) / 200_000
    direction = np.stack([np.sqrt(1 - cosine**2), np.zeros_like(cosine), -cosine])
    shares = falloff(lamp, direction)
    assert 2 * np.pi * shares.mean() == pytest.approx(np.pi, rel=1e-3)
    assert not shares[cosine < np.cos(np.radians(degrees / 2))].any()
    assert not falloff(lamp, -direction).any()


def test_a_small_lamp_far_away_is_a_point_with_a_cosine():
    light = panel((0.01, 0.01), (0.0, 0.0, 9.0))
    image = bake(under(light, calm, 48, 1.333)).images[0]
    point = Point("Point", light.position, light.intensity)
    x, y = centres(32)
    straight = 7.5 / np.hypot(np.hypot(x, y) * 0.87, 7.5)  # of where it enters, about
    other = bake(under(point, calm, 48, 1.333)).images[0] * straight[..., None]
    assert off(image, other) < 1e-4
    assert len(cut(under(light), [rasterise(floor(), 32)], 1e-2)[0].lights) == 1


def test_it_is_cut_as_finely_as_the_tolerance_asks_for_and_no_finer():
    texels = [rasterise(floor(), 256)]
    counts = [len(cut(under(panel()), texels, tolerance)[0].lights) for tolerance in (5e-2, 1e-2, 1e-3)]
    assert counts == sorted(counts) and counts[0] == 1 and counts[1] < counts[2] <= 16


def test_pieces_share_its_light_and_its_middle():
    for light in (panel((0.8, 0.3)), panel((0.8, 0.3), round=True)):
        made = pieces(light, (5, 4))
        assert {among(p) for p in made} == {20} and {lamp_of(p) for p in made} == {"Panel"}
        assert len({p.name for p in made}) == 20
        np.testing.assert_allclose(sum(p.intensity for p in made), light.intensity)
        places = np.array([p.position for p in made]) - light.position
        np.testing.assert_allclose(places.mean(0), 0, atol=1e-12)
        own = sum(np.einsum("ki,kj->ij", p.half_axes, p.half_axes) for p in made) / (4 * len(made))
        spread = np.einsum("ki,kj->ij", places, places) / len(made) + own
        whole = np.diag([0.8, 0.3, 0]) ** 2 / (4 if light.round else 3)
        np.testing.assert_allclose(spread, whole, atol=1e-2 if light.round else 1e-12)


def test_what_is_under_the_water_is_said_and_sends_no_light_through_it():
    """A panel on edge, half of it under water."""
    upright = replace(panel((0.3, 0.3)), position=np.array([-1.5, 0.0, 1.5]))
    upright = replace(upright, half_axes=np.array([[0.0, 0.3, 0.0], [0.0, 0.0, 0.3]]))
    answer = bake(under(upright, eta=1.333), tolerance=1e-2)
    assert any("the part of the lamp 'Panel' under the water: 50%" in s for s in answer.diagnostics.left_out)
    assert answer.images[0].max() > 0
    dry = replace(upright, position=np.add(upright.position, [0, 0, 0.15]), half_axes=upright.half_axes * [[1], [0.5]])
    dry = bake(under(replace(dry, intensity=upright.intensity / 2), eta=1.333), tolerance=1e-2)
    assert off(answer.images[0], dry.images[0]) < 0.02


def test_a_lamp_that_shines_up_lights_nothing():
    up = replace(panel(), half_axes=panel().half_axes[::-1])
    assert not bake(under(up)).images[0].any()


def test_narrow_light_of_a_wide_lamp_is_cut_finely_or_said():
    lights = [panel((0.5, 0.5), spread=np.radians(degrees)) for degrees in (30, 2)]
    texels = [rasterise(floor(), 32)]
    (fine, said), (_, narrow) = (cut(under(light), texels, 1e-2) for light in lights)
    assert 1 < len(fine.lights) <= 64 and not said
    assert "pieces of the lamp 'Panel'" in narrow[0]


def test_impossible_lamps_are_refused():
    with pytest.raises(ValueError, match="half_axes of 'Panel' must enclose an area"):
        bake(under(replace(panel(), half_axes=np.zeros((2, 3)))))
    with pytest.raises(ValueError, match="half_axes of 'Panel' must be finite"):
        bake(under(replace(panel(), half_axes=np.full((2, 3), np.nan))))
    with pytest.raises(ValueError, match="half_axes must have shape"):
        replace(panel(), half_axes=np.zeros(3))
    with pytest.raises(ValueError, match="spread must lie"):
        panel(spread=4.0)


@pytest.mark.parametrize("method", METHODS)
def test_far_from_the_origin_it_is_the_same(method):
    scene = pool(calm, 24, side=4.8)
    scene = replace(scene, lights=(panel(),))
    far = np.array([5000.0, -3000.0, 100.0])
    moved = replace(
        scene,
        water=replace(scene.water, positions=scene.water.positions + far),
        receivers=tuple(replace(r, positions=r.positions + far) for r in scene.receivers),
        lights=(replace(panel(), position=HIGH + far),),
    )
    here, there = (bake(s, 16, tolerance=1e-2, method=method).images[0] for s in (scene, moved))
    np.testing.assert_allclose(there, here, atol=2e-3 * here.max())


def test_automatic_plans_for_it():
    scene = under(panel((1.5, 1.5)), five_sines, 48, 1.333, side=4.8)
    texels = [rasterise(scene.receivers[0], 32)]
    settings = Settings(tolerance=5e-2)
    anchor = prepare(scene, texels, settings)
    assert anchor.plan is not None
    answer = solve(scene, texels, settings)
    assert answer.diagnostics.plan


def over_a_ball(half):
    light = panel((half, half), (0.6, 0.0, 3.0))
    return Scene(no_water(), (floor(2.0),), (), (light,), casters=(ball(0.3, (0.0, 0.0, 0.5), 24),))


def test_over_a_ball_of_glass_it_is_the_sum_of_its_points():
    """Its focus is as wide as the lamp seen from there, and the books hold what the ball is lit by."""
    scene = over_a_ball(0.1)
    answer = bake(scene, 32, tolerance=1e-2)
    places = within_disc(pieces(scene.lights[0], (1, 1))[0], 48, np.random.default_rng(9))
    parts = tuple(replace(p, name=f"{k}", intensity=p.intensity / 48) for k, p in enumerate(places))
    expected = bake(replace(scene, lights=parts), 32, tolerance=0.5)
    assert off(answer.images[0], expected.images[0]) < 2e-2
    np.testing.assert_allclose(answer.diagnostics.flux_in, expected.diagnostics.flux_in, rtol=5e-3)
    d = answer.diagnostics
    np.testing.assert_allclose(d.flux_received["Floor"] + sum(d.flux_lost.values()), d.flux_in, rtol=1e-9)
    assert answer.images[0].max() < 0.9 * 100 * bake(over_a_ball(0.01), 32, tolerance=1e-2).images[0].max()


def through_plate(points, out, thick=0.2):
    """Irradiance on points (n,3) of z = 0 below a plate, of a flat lamp of 1 W/sr at a point (3,), over all orders."""
    rho = np.linalg.norm((points - out)[:, :2], axis=1)
    air, total = out[2] - thick, 0.0
    for order in range(3):
        glass, low, high = thick * (2 * order + 1), np.zeros(len(points)), np.full(len(points), 1 - 1e-9)
        for _ in range(50):
            sine = (low + high) / 2
            short = air * sine / np.sqrt(1 - sine**2) + glass * sine / np.sqrt(2.25 - sine**2) < rho
            low, high = np.where(short, sine, low), np.where(short, high, sine)
        cosine = np.sqrt(1 - sine**2)
        once = np.array([1 - transmitted(c, 1.5) for c in cosine])
        slope = air / cosine**3 + glass * 2.25 / (2.25 - sine**2) ** 1.5
        geometry = np.where(rho > 1e-6, sine / np.maximum(rho, 1e-12) / (slope * cosine), (air + glass / 1.5) ** -2)
        total = total + cosine * (1 - once) ** 2 * once ** (2 * order) * geometry
    return total


def test_through_a_plate_of_glass():
    """A lamp 1.2 by 0.6 m: texel by texel, and its books."""
    plate, light = slab((-2, -2, 1.0), (2, 2, 1.2)), panel((0.6, 0.3), (0.0, 0.0, 4.0))
    scene = Scene(no_water(), (floor(side=1.0),), (), (light,), casters=(plate,))
    (own,) = texels = [rasterise(scene.receivers[0], 12, padding=0)]
    answer = solve(scene, texels, Settings(resolution=12, tolerance=1e-2, bounces=8))
    places = [piece.position for piece in pieces(light, (16, 16))]
    expected = np.mean([through_plate(own.positions, place) for place in places], axis=0) * light.intensity[0]
    got = answer.images[0].reshape(-1, 3)[own.texel, 0]
    assert got.mean() == pytest.approx(expected.mean(), rel=3e-3)
    assert off(got, expected) < 1e-3
    work = answer.diagnostics
    total = sum(work.flux_received.values()) + sum(work.flux_lost.values())
    np.testing.assert_allclose(total, work.flux_in, rtol=1e-9)


def test_what_meets_a_ball_is_what_the_lamp_sends_there():
    """The ball's form factor: pi I (r / d)^2 of a small flat lamp that faces it, and nothing of one that looks away."""
    down = panel((0.001, 0.001), (0.0, 0.0, 4.0))
    for light, share in ((down, 1.0), (replace(down, half_axes=down.half_axes[::-1]), 0.0)):
        glass = ball(0.4, fine=96)
        scene = Scene(no_water(), (floor(side=1.0, z=-1.0),), (), (light,), casters=(glass,))
        work = bake(scene, 32, tolerance=1e-2).diagnostics
        assert work.flux_in[0] == pytest.approx(share * np.pi * light.intensity[0] * (0.4 / 4.0) ** 2, rel=5e-3)


def test_places_over_casters_that_are_too_few_are_said_once():
    scene = over_a_ball(0.8)
    said = bake(replace(scene, casters=(ball(0.3, (0.0, 0.0, 0.5), 6),)), 64, tolerance=5e-2).diagnostics
    assert [s for s in said.left_out if "'Panel'" in s] == ["what is between 64 points of 'Panel', over casters"]
    assert said.estimated_error > 0
