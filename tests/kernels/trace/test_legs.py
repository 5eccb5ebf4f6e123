"""Legs of paths that are told without a ray, or by one among few triangles, against rays among everything."""

import numpy as np
import pytest
from bench import caster_shapes as shapes
from caster_rays import scene
from casters import GLASS, SILVER, no_water, patch, prism, slab
from waves import flat, floor, turned, water

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.rays import Tracer
from dapple.kernels.scene import Occluder
from dapple.kernels.trace.arrivals import Arrivals
from dapple.kernels.trace.follow import Follower, Rays
from dapple.kernels.trace.legs import Legs
from dapple.kernels.trace.meeting import Meeting
from dapple.kernels.trace.surfaces import Surfaces

TABLE = floor(4.0, 0.0)


def ball(at, radius=0.5, parts=64, material=GLASS):
    return shapes.caster("Ball", shapes.ball(radius, parts), material, at)


def board(low, high):
    block = slab(low, high)
    return Occluder("Board", block.positions, block.triangles)


def bowl():
    """The lower half of a sphere of glass, one thin sheet: it is not convex, and a ball may lie in it."""
    v, u = np.linspace(np.pi / 2, np.pi, 9), np.linspace(0, 2 * np.pi, 33)
    return patch(
        lambda u, v: (0.8 * np.sin(v) * np.cos(u), 0.8 * np.sin(v) * np.sin(u), 1 + 0.8 * np.cos(v)),
        lambda u, v: (np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)),
        u,
        v,
    )


SCENES = {
    "a ball over a table": scene(ball((0, 0, 1)), receivers=(TABLE,)),
    "a ball that touches it": scene(ball((0, 0, 0.5)), receivers=(TABLE,)),
    "a ball that it cuts": scene(ball((0, 0, 0.4)), receivers=(TABLE,)),
    "a ball at the end of a table": scene(ball((1.9, 0, 1)), receivers=(TABLE,)),
    "the back of a table": scene(ball((0, 0, 1)), receivers=(turned(TABLE),)),
    "two balls and a prism": scene(
        ball((0, 0, 1)), ball((0.3, 1.1, 0.6), material=SILVER), prism(1.0, 0.5, 1.0), receivers=(TABLE,)
    ),
    "a ball in another": scene(ball((0, 0, 1)), ball((0, 0, 1.1), 0.2), receivers=(TABLE,)),
    "a ball in a bowl": scene(ball((0, 0, 0.8), 0.4), bowl(), receivers=(TABLE,)),
    "things beside it": scene(ball((0, 0, 1)), receivers=(TABLE,), occluders=(board((0.6, -0.4, 0), (0.7, 0.4, 1.5)),)),
    "a mirror behind it": scene(
        ball((0, 0, 1)),
        patch(lambda u, v: (0 * u - 1, u, v), lambda u, v: (1 + 0 * u, 0 * u, 0 * u), [-2, 2], [0, 2], material=SILVER),
        receivers=(TABLE,),
    ),
    "under water": scene(ball((0, 0, 1)), over=water(flat, quads=2, side=6, level=2.0), receivers=(TABLE,)),
    "half under water": scene(ball((0, 0, 1)), over=water(flat, quads=2, side=6, level=1.1), receivers=(TABLE,)),
}


def ends(where, count=4000):
    """{(photon, code): (what it ends on, where, direction)} of light from above, and how many rays were cast."""
    surfaces, rng = Surfaces(where, np.ones(3)), np.random.default_rng(0)
    origin = np.stack([*rng.uniform(-0.7, 0.7, (2, count)), np.full(count, 5.0)])
    centre = where.casters[0].positions.mean(0)
    direction = np.array([0.4, 0.1, -1.0]) / np.linalg.norm([0.4, 0.1, -1.0])
    origin[:2] += (centre + direction * (5 - centre[2]) / direction[2])[:2, None]
    rays = Rays.of(origin, np.tile(direction[:, None], count), len(surfaces.sigma_a))
    arrivals = Arrivals(where.receivers, [rasterise(r, 64) for r in where.receivers], surfaces)
    found = {}
    for ended, end in Follower(surfaces, 6, 1e-4).ends(rays):
        kind = np.where(end >= surfaces.receiving, surfaces.receiving, np.where(end >= 0, 0, end))
        landed = arrivals.of(ended, end)
        place = np.zeros((5, len(end)))
        place[:, landed.ray] = np.stack([landed.chart, landed.x, landed.y, landed.way, landed.colour[0]])
        rows = np.concatenate([kind[None], ended.share[None], ended.direction, place]).T
        found |= dict(zip(zip(ended.photon.tolist(), ended.code.tolist(), strict=True), rows, strict=True))
    return found


@pytest.fixture
def counted(monkeypatch):
    """How many rays were cast among everything, and among less."""
    rays, first, largest = [0, 0], Tracer.first, [0]

    def counting(self, origins, directions):
        largest[0] = max(largest[0], self.count)
        rays[self.count < largest[0]] += len(origins)
        return first(self, origins, directions)

    monkeypatch.setattr(Tracer, "first", counting)
    return rays


@pytest.mark.parametrize("name", SCENES)
def test_all_paths_end_where_rays_among_everything_do(name, monkeypatch):
    found = ends(SCENES[name])
    monkeypatch.setattr(Legs, "first", lambda self, start, direction, left: self._tracer.first(start.T, direction.T))
    among_all = ends(SCENES[name])
    assert len(found) > 3000
    missing = len(found.keys() ^ among_all.keys())
    both = sorted(found.keys() & among_all.keys())
    one, other = (np.array([paths[key] for key in both]) for paths in (found, among_all))
    differ = (np.abs(one - other) > 1e-4).any(1).sum()
    assert missing + differ <= 1e-3 * len(both), "but for those through an edge"
    assert abs(one[:, 1].sum() - other[:, 1].sum()) < 1e-4 * other[:, 1].sum()


def test_a_ball_over_a_table_takes_one_ray_among_everything(counted):
    """That from the light: what is inside is sought in the ball, and what comes out needs none."""
    where = SCENES["a ball over a table"]
    found = ends(where)
    assert 4000 <= counted[0] < 4040 and 4000 < counted[1] < len(found), "a few graze a dent"


def test_a_ball_that_is_touched_by_another_is_not_sought_alone(counted):
    ends(SCENES["a ball in another"])
    assert counted[0] > 12000


@pytest.mark.parametrize("name", ["a ball in another", "a ball that it cuts", "half under water"])
def test_nothing_is_told_of_bodies_that_something_reaches_into(name):
    surfaces = Surfaces(SCENES[name], np.ones(3))
    assert not (surfaces.legs.left < 0).any()


def test_many_things_are_left_to_the_ray_library():
    balls = [ball((x, y, 1), 0.2, 16) for x in range(3) for y in range(3)]
    assert not Surfaces(scene(*balls, receivers=(TABLE,)), np.ones(3)).legs.known
    assert not Surfaces(scene(receivers=(TABLE,), over=no_water()), np.ones(3)).legs.known


@pytest.mark.parametrize("name", SCENES)
def test_hits_are_what_first_finds_and_as_far_away(name):
    surfaces = Surfaces(SCENES[name], np.ones(3))
    rng = np.random.default_rng(5)
    origin = np.stack([rng.uniform(-0.7, 2.0, 2000), rng.uniform(-0.5, 0.5, 2000), np.full(2000, 3.0)])
    rays = Rays.of(origin, np.tile([[0.1], [0.05], [-1.0]], 2000) / np.linalg.norm([0.1, 0.05, 1]), 1)
    checked = 0
    for _ in range(3):
        end, distance, doubtful = surfaces.hits(rays)
        np.testing.assert_array_equal(end, surfaces.first(rays))
        expected = surfaces.distance(rays.origin, rays.direction, end)
        met = end >= 0
        off = np.abs(distance[met] - expected[met])
        assert (off > 5e-5).sum() <= 0.05 * len(off) and off.max(initial=0) < 0.01, "but for what grazes facets"
        assert np.isinf(distance[~met]).all() and doubtful.sum() < 40
        at = np.flatnonzero(end >= surfaces.solid)
        checked += len(at)
        rays = Meeting(surfaces, rays, at, end[at]).leave()
    assert checked > 300


def test_what_marks_a_mesh_changes_as_another_comes_into_its_box():
    def mark(x):
        other = ball((x, 0, 1.2), 0.1, 16)
        return Surfaces(scene(ball((0, 0, 1)), other, receivers=(TABLE,)), np.ones(3)).legs.mark(1)

    assert mark(1.5) == mark(1.4) != mark(0.45) and mark(1.5) == [-2, 2]
