"""Maps of light over casters: energy, points against closed forms, and what the books say."""

from dataclasses import replace

import numpy as np
import pytest
from casters import SILVER, ball, no_water, patch, room, slab
from waves import flat, floor, quad, sun, transmitted, water

from dapple.kernels.casters import Mirror, Volume
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Point, Receiver, Scene, Settings, Spot, Sun
from dapple.kernels.trace.cast import over_casters


def baked(scene, side=32, **settings):
    texels = [rasterise(r, side, padding=0) for r in scene.receivers]
    return solve(scene, texels, Settings(resolution=side, **settings))


def grid_floor(x, height):
    """A level receiver of quads between coordinates x (n,) both ways."""
    grid_x, grid_y = (v.ravel() for v in np.meshgrid(x, x))
    row, column = np.divmod(np.arange((len(x) - 1) ** 2), len(x) - 1)
    first = row * len(x) + column
    quads = np.stack([first, first + 1, first + len(x) + 1, first + len(x)], 1)
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    uv = np.stack([grid_x, grid_y], 1) / np.ptp(x) + 0.5
    return Receiver("Floor", np.stack([grid_x, grid_y, np.full(len(grid_x), height)], 1), triangles, uv[triangles])


def total(watts):
    return sum(watts.values(), np.zeros(3))


@pytest.mark.parametrize("points", [False, True])
def test_energy_of_a_glass_ball_in_a_closed_room(points):
    """All that meets the ball - its solid angle - arrives on the six sides, but for what is booked, within 0.3 %."""
    lamp = np.array([0.3, 0.2, 1.5])
    scene = Scene(no_water(), room(2.0), (), (Point("Lamp", lamp, np.ones(3)),), casters=(ball(0.5, fine=96),))
    d = baked(scene, bounces=8, points=points).diagnostics
    solid_angle = 2 * np.pi * (1 - np.sqrt(1 - 0.25 / (lamp @ lamp)))
    assert d.flux_in[0] == pytest.approx(solid_angle, rel=3e-3)
    np.testing.assert_allclose(total(d.flux_received) + total(d.flux_lost), d.flux_in, rtol=1e-6)
    np.testing.assert_allclose(total(d.flux_received), d.flux_in, rtol=3e-3)


def test_what_misses_the_receivers_is_booked_whole():
    """A ball of glass turns back what grazes its outline, and none of that comes to the floor behind it."""
    scene = Scene(no_water(), (floor(side=1.0, z=-1.0),), (), (sun((0.3, 0.2, -1)),), casters=(ball(0.4, fine=96),))
    texels = [rasterise(scene.receivers[0], 16, padding=0)]
    coarse = (Settings(resolution=16, tolerance=0.1, seed=seed) for seed in range(6))
    met = [over_casters(scene, texels, settings)[0].spread()[2][0] for settings in coarse]
    assert np.mean(met) == pytest.approx(np.pi * 0.16, rel=3.5e-3)


def test_a_slab_over_a_floor_passes_its_share_and_shades_nothing():
    """The sum over all inner reflections of (1 - F)^2 F^2k is (1 - F) / (1 + F)."""
    block = slab((-3, -3, 0.5), (3, 3, 0.6))
    scene = Scene(no_water(), (floor(side=1.0),), (), (sun((0, 0, -1)),), casters=(block,))
    answer = baked(scene, side=8, bounces=8, tolerance=1e-3)
    assert answer.images[0][2:6, 2:6, 0].mean() == pytest.approx(0.96 / 1.04, rel=1e-3)


@pytest.mark.parametrize("height", [0.0, -1.234567])
@pytest.mark.parametrize("part", [1, 2], ids=["one quad", "quads"])
def test_a_block_that_stands_on_the_table_lights_it(height, part):
    """Its lower face and the table lie in one place: light that leaves the one is on the other."""
    block = slab((-0.5, -0.5, height), (0.5, 0.5, height + 0.4))
    table = floor(side=2.0, z=height)
    if part > 1:
        x = np.linspace(-1, 1, 2 * part + 1)
        table = grid_floor(x, height)
    scene = Scene(no_water(), (table,), (), (sun((0, 0, -1)),), casters=(block,))
    image = baked(scene, side=16, bounces=8, tolerance=1e-3).images[0][..., 0]
    np.testing.assert_allclose(image[6:10, 6:10], 0.96 / 1.04, rtol=1e-3)
    assert not image[:3].any()


@pytest.mark.parametrize("lamp", [sun((0.2, 0, -1)), Point("Lamp", np.array([0.0, 0.1, 1.0]), np.ones(3))])
def test_mountains_far_away_leave_a_marble_its_light(lamp):
    """Rays are cast in single precision: a ball of 5 cm, and a wall 6 km wide, 3 km off."""
    far = 3e3
    wall = quad("Wall", [[far, -far, -far], [far, far, -far], [far, far, far], [far, -far, far]])
    marble = ball(0.05, (0, 0, 0.07), fine=32)
    scene = Scene(no_water(), (floor(side=0.4),), (), (lamp,), casters=(marble,))
    alone = baked(scene, side=32).images[0]
    before = baked(replace(scene, occluders=(Occluder("Wall", wall.positions, wall.triangles),)), side=32).images[0]
    assert ((alone - before) ** 2).mean() < 2e-4 * (alone**2).mean()


def test_the_same_through_still_water():
    """Water, then the slab in it; nothing comes twice by the water's own way, which the slab blocks."""
    block = slab((-3, -3, 0.5), (3, 3, 0.6))
    over = water(flat, quads=8, side=8.0, level=1.5)
    scene = Scene(over, (floor(side=1.0),), (), (sun((0.3, 0, -1)),), casters=(block,))
    answer = baked(scene, side=8, bounces=10, tolerance=1e-3)
    cos_i = 1 / np.sqrt(1.09)
    cos_w = np.sqrt(1 - (0.3 * cos_i / 1.333) ** 2)
    inner = 1 - transmitted(cos_w, 1.5 / 1.333)
    expected = cos_i * transmitted(cos_i) * (1 - inner) / (1 + inner)
    assert answer.images[0][2:6, 2:6, 0].mean() == pytest.approx(expected, rel=3e-3)


def test_a_mirror_lights_the_wall_and_no_direct_light_counts():
    """A flat mirror of reflectance 0.8, 1 m wide, under a sun: a bright patch of 0.8 on a wall at 45 degrees."""
    tilted = slab((-0.5, -0.5, -0.6), (0.5, 0.5, -0.5), Mirror(np.full(3, 0.8), np.full(3, 0.8)))
    scene = Scene(no_water(), room(2.0)[3:4], (), (sun((0, 1, -1)),), casters=(tilted,))
    answer = baked(scene, side=32, tolerance=1e-3)
    assert np.median(answer.images[0][answer.images[0] > 0.3]) == pytest.approx(0.8 * np.sqrt(0.5), rel=2e-2)
    assert answer.diagnostics.flux_received["Side 3"][0] == pytest.approx(0.8 * np.sqrt(0.5), rel=1e-2)


@pytest.mark.parametrize("lamp", ["point", "spot"])
def test_lamps_all_round_a_mirror_ball(lamp):
    """What a small ball takes of a lamp beside it, whichever face of the cube it is on."""
    intensity = np.array([1.0, 0.5, 0.0])
    for axis in np.concatenate([np.eye(3), -np.eye(3)]):
        position = 1.1 * axis
        if lamp == "point":
            light = Point("Lamp", position, intensity)
        else:
            frame = np.linalg.qr(np.column_stack([-axis, [0.3, 0.4, 0.5], [0.9, -0.4, 0.1]]))[0].T[[1, 2, 0]]
            frame *= np.sign(frame[2] @ -axis)
            light = Spot("Lamp", position, intensity, frame=frame, half_angle=0.2)
        scene = Scene(
            no_water(), room(2.0), (), (light,), casters=(ball(0.3, fine=48, material=Mirror(*np.ones((2, 3)))),)
        )
        solid_angle = 2 * np.pi * (1 - (np.sqrt(1 - (0.3 / 1.1) ** 2) if lamp == "point" else np.cos(0.2)))
        d = baked(scene, side=16, tolerance=0.1).diagnostics
        np.testing.assert_allclose(total(d.flux_received), intensity * solid_angle, rtol=1e-2)
        np.testing.assert_allclose(total(d.flux_received), d.flux_in, rtol=1e-3)


def test_light_that_leaves_the_volume_by_a_culling_face_is_booked():
    matrix = np.diag([1.0, 1.0, 1.0, 1.0])
    for culling, cause in (((False,) * 6, None), ((True,) * 6, "culled")):
        scene = Scene(
            no_water(), room(2.0), (), (sun((0, 0, -1)),), casters=(slab((-0.5, -0.5, -0.1), (0.5, 0.5, 0.1)),),
            volume=Volume(matrix, culling),
        )  # fmt: skip
        d = baked(scene, side=32).diagnostics
        assert d.flux_in[0] == 0, "the room's own ceiling is in the way"
        open_room = Scene(no_water(), room(2.0)[:1], (), scene.lights, casters=scene.casters, volume=scene.volume)
        d = baked(open_room, side=32).diagnostics
        assert d.flux_in[0] == pytest.approx(1.0, rel=1e-2)
        received = total(d.flux_received)[0]
        if cause:
            assert received == 0 and d.flux_lost["culled"][0] == pytest.approx(1.0, rel=1e-2)
        else:
            assert received == pytest.approx(0.96 / 1.04, rel=1e-2)


@pytest.mark.parametrize("lamp", [sun((0, 0, -1)), Point("Lamp", np.array([0.0, 0.0, 2.0]), np.ones(3))])
def test_light_is_aimed_at_what_the_volume_holds(lamp):
    """One ball of two: light sets out towards it alone, as if the other were not there."""
    near, other = ball(0.1, (0.5, 0, 0.3), fine=12), ball(0.1, (-0.5, 0, 0.3), fine=12, name="Other")
    matrix = np.diag([0.2, 0.2, 0.2, 1.0])
    matrix[:3, 3] = 0.5, 0, 0.3

    def aimed(casters, volume):
        scene = Scene(no_water(), (floor(side=2.0),), (), (lamp,), casters=casters, volume=volume)
        (cast,) = over_casters(scene, [rasterise(scene.receivers[0], 64)], Settings(resolution=64))
        return (cast.entry.lit.area > 0).sum(), cast.entry.lit.area.sum()

    bounded, alone, both = aimed((near, other), Volume(matrix)), aimed((near,), None), aimed((near, other), None)
    assert bounded == pytest.approx(alone) and bounded[1] < 0.75 * both[1]


def test_a_volume_that_holds_no_caster_lets_nothing_cast():
    away = np.eye(4)
    away[:3, 3] = 9.0
    lamp = Point("Lamp", np.array([0.0, 0.0, 2.0]), np.ones(3))
    for light in (sun((0, 0, -1)), lamp, replace(sun((0, 0, -1)), angle=0.1)):
        scene = Scene(no_water(), (floor(side=1.0),), (), (light,), casters=(ball(0.2, (0, 0, 0.5), fine=12),))
        answer = baked(replace(scene, volume=Volume(away)), side=8)
        assert not answer.images[0].any() and not answer.diagnostics.flux_in.any()


def test_beams_are_what_points_are_texel_by_texel():
    """Glass and a mirror over a floor: beams lie within the noise of points, known from points drawn apart."""
    casters = (
        ball(0.15, (-0.2, 0, 0.2), fine=64),
        ball(0.1, (0.25, 0.1, 0.1), fine=48, material=SILVER, name="Mirror"),
    )
    scene = Scene(no_water(), (floor(side=1.0),), (), (sun((0.3, 0.1, -1)),), casters=casters)
    texels = [rasterise(scene.receivers[0], 32, padding=0)]
    cast = over_casters(scene, texels, Settings(resolution=32))[0]
    draws = np.stack([cast.throw(60_000, np.random.default_rng([1, k]))[0][:, 0] for k in range(8)])
    mean, error = draws.mean(0), draws.std(0, ddof=1) / np.sqrt(8)
    beams = over_casters(scene, texels, Settings(resolution=32, tolerance=1e-6))[0].spread()[0][:, 0]
    assert beams.sum() == pytest.approx(mean.sum(), rel=2e-3)
    assert ((beams - mean) ** 2).mean() - (error**2).mean() < 1e-4 * (mean**2).mean()
    off = (beams - mean) / (error + 0.02 * (mean + mean.mean()))
    assert np.count_nonzero(np.abs(off) > 4) <= 20 and np.abs(off).max() < 20


def test_the_nephroid_of_a_cylinder():
    """A cylindrical mirror 60 degrees to either side, lit along x and down at 45 degrees. Light that met it at an angle
    a and went s on in plan has the density 1 / |1 - 2 s / (R cos a)|: it is infinite on the nephroid, whose cusp is
    halfway between the mirror and its centre."""

    def normal(u, v):
        return -np.cos(u), -np.sin(u), 0 * v

    wall = patch(
        lambda u, v: (np.cos(u), np.sin(u), v), normal, np.linspace(-1.05, 1.05, 241), np.array([0.0, 0.9]), SILVER
    )
    scene = Scene(no_water(), (floor(side=2.4),), (), (sun((1, 0, -1)),), casters=(wall,))
    image = baked(scene, side=120, tolerance=1e-4).images[0][..., 0]
    step = 2.4 / 120
    axis = (np.arange(120) + 0.5) * step - 1.2
    before = slice(68, 78)  # of the cusp, on the axis, one ray arrives: the density falls as 1 / |1 - 2 s|
    slope, at = np.polyfit(axis[before], np.sqrt(0.5) / image[59:61, before].mean(0), 1)
    assert slope == pytest.approx(-2, rel=2e-2) and -at / slope == pytest.approx(0.5, abs=3e-3)
    checked = 0
    for row, column in ((60, 95), (70, 100), (50, 98), (60, 100), (75, 97)):
        x, y = axis[column], axis[row]
        expected = np.sqrt(0.5) * sum(1 / abs(1 - 2 * s / np.cos(a)) for a, s in _reflected_to(x, y) if s < 0.9)
        assert image[row, column] == pytest.approx(expected, rel=0.05)
        checked += 1
    assert checked == 5


def _reflected_to(x, y):
    """Angles a on a unit circle, and ways s from there, of light along x that is reflected to (x, y)."""
    a = np.linspace(-1.05, 1.05, 20001)
    across = (x - np.cos(a)) * -np.sin(2 * a) - (y - np.sin(a)) * -np.cos(2 * a)
    at = np.flatnonzero(across[1:] * across[:-1] < 0)
    way = -(x - np.cos(a[at])) * np.cos(2 * a[at]) - (y - np.sin(a[at])) * np.sin(2 * a[at])
    return [(angle, s) for angle, s in zip(a[at], way, strict=True) if s > 0]


def test_what_is_left_out_is_said():
    light = Sun("Sun", np.array([0.0, 0.0, -1.0]), np.ones(3), angle=0.5)
    scene = Scene(no_water(), (floor(side=1.0),), (), (light,), casters=(ball(0.2, (0, 0, 0.3), fine=24),))
    said = " ".join(baked(scene, side=16, bounces=2).diagnostics.left_out)
    assert "disc" in said and "more than 2 surfaces (bounces)" in said and "twice" not in said
    plain = replace(scene, lights=(sun((0, 0, -1)),))
    said = " ".join(baked(plain, side=16).diagnostics.left_out)
    assert "disc" not in said and "bounces" not in said
