"""Maps whose texels differ in size, over casters: each as it is by itself, in time that goes with what it can show."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball, no_water, slab
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Point, Receiver, Scene, Settings
from dapple.kernels.trace.follow import Follower

TABLE = floor(side=1.0)
BALL = ball(0.12, (-0.05, 0, 0.16), fine=24)
SIDE = 64
OVER = 1e-4  # m: a coin lies on the table
SUN = sun((0.5, 0.22, -1))
SETTINGS = Settings("photon_splat", surface="mesh")


@pytest.fixture
def rays(monkeypatch):
    """Counts the rays that are cast over casters, in rays[0]."""
    cast, count = Follower.ends, [0]

    def ends(self, *args):
        before = self.cast
        yield from cast(self, *args)
        count[0] += self.cast - before

    monkeypatch.setattr(Follower, "ends", ends)
    return count


def coin(side, x, y):
    """A square on the table."""
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
    positions = np.column_stack([side * corner + (x, y), np.full(4, OVER)])
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    return Receiver("Coin", positions, triangles, (corner + 0.5)[triangles])


def over(caster, *coins, lights=(SUN,)):
    return Scene(no_water(), (TABLE, *coins), (), lights, casters=(caster,))


def baked(scene, *sizes, **settings):
    texels = [rasterise(r, side, padding=0) for r, side in zip(scene.receivers, sizes, strict=True)]
    return solve(scene, texels, replace(SETTINGS, **settings))


def closed(work):
    received, lost = sum(work.flux_received.values()), sum(work.flux_lost.values())
    np.testing.assert_allclose(received + lost, work.flux_in, rtol=1e-6)


def test_a_coin_is_lit_as_a_slab_lets_pass():
    """The sum over all inner reflections of (1 - F)^2 F^2k is (1 - F) / (1 + F)."""
    scene = over(slab((-0.2, -0.2, 0.1), (0.2, 0.2, 0.14)), coin(0.02, 0.05, 0.03), lights=(sun((0, 0, -1)),))
    answer = baked(scene, SIDE, 16, bounces=8, tolerance=1e-3)
    light = answer.images[1][..., 0]
    np.testing.assert_allclose(light[2:-2, 2:-2], 0.96 / 1.04, rtol=1e-3)
    assert light.mean() == pytest.approx(0.96 / 1.04, rel=1e-2)
    closed(answer.diagnostics)


@pytest.mark.parametrize("lamp", [SUN, Point("Lamp", np.array([-0.55, -0.25, 1.0]), np.ones(3))])
@pytest.mark.parametrize("place", [(0.06, 0.03), (0.02, 0.06)], ids=["focus", "beside"])
def test_a_coin_is_lit_as_a_map_all_as_fine(place, lamp):
    one = coin(0.06, *place)
    scene = over(BALL, one, lights=(lamp,))
    small = baked(scene, SIDE, 16)
    alone = baked(replace(scene, receivers=(one,)), 32, tolerance=1e-3)
    fine = alone.images[0].reshape(16, 2, 16, 2, 3).mean((1, 3))
    assert ((small.images[1] - fine) ** 2).mean() < 1e-2 * (fine**2).mean()
    assert small.images[1].mean() == pytest.approx(fine.mean(), rel=1e-2)
    closed(small.diagnostics)


def test_the_table_is_as_without_the_coin_but_for_what_lies_under_it():
    one = coin(0.03, 0.02, 0.06)
    with_coin, without = baked(over(BALL, one), SIDE, 16), baked(over(BALL), SIDE)
    received = with_coin.diagnostics.flux_received
    total = without.diagnostics.flux_received["Floor"]
    np.testing.assert_allclose(sum(received.values()), total, rtol=2e-3)
    away = np.hypot(*np.meshgrid(*[(np.arange(SIDE) + 0.5) / SIDE - 0.5] * 2)) > 0.15
    ours, theirs = with_coin.images[0][away], without.images[0][away]
    assert ((ours - theirs) ** 2).sum() < 1e-2 * (theirs**2).sum()


@pytest.mark.parametrize(("angle", "most"), [(0.0, 2), (0.01, 12)], ids=["plain", "disc"])
def test_a_coin_of_a_few_texels_costs_few_rays(rays, angle, most):
    """Of a disc, which shows on the coin alone, 16 directions are looked for. One pass for all took 35 times the rays
    of the table without a disc."""
    lights = (replace(SUN, angle=angle),)
    baked(over(BALL, lights=lights), SIDE)
    table, rays[0] = rays[0], 0
    baked(over(BALL, coin(0.01, 0.2, 0.1), lights=lights), SIDE, 16)
    assert 0 < table < rays[0] < most * table


def test_finer_maps_of_a_coin_cost_rays_by_their_texels(rays):
    counts = []
    for side in (16, 32, 64):
        rays[0] = 0
        baked(over(BALL, coin(0.01, 0.06, 0.03)), SIDE, side)
        counts.append(rays[0])
    assert counts[1] < 4 * counts[0] and counts[2] < 4 * counts[1], counts


def test_a_coin_in_the_dark_costs_next_to_nothing(rays):
    baked(over(BALL), SIDE)
    table, rays[0] = rays[0], 0
    answer = baked(over(BALL, coin(0.01, -0.45, -0.45)), SIDE, 64)
    assert answer.images[1].mean() < 1e-2 * answer.images[0].mean() and rays[0] < 3 * table


def test_points_light_all_receivers_at_once():
    one = coin(0.03, 0.06, 0.03)
    points = baked(over(BALL, one), SIDE, 16, points=True, tolerance=0.1)
    beams = baked(over(BALL, one), SIDE, 16)
    assert points.images[1].mean() == pytest.approx(beams.images[1].mean(), rel=0.05)
    closed(points.diagnostics)
