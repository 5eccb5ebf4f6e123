"""Which places ways come through: boxes of bodies, and segments against boxes."""

import numpy as np
from caster_rays import scene
from casters import ball, slab
from waves import floor

from dapple.kernels.trace.follow import Follower, Rays
from dapple.kernels.trace.surfaces import Surfaces
from dapple.kernels.trace.trail import Bodies, Trail, crossing


def test_boxes_of_bodies_are_joined_where_they_overlap():
    """A chain of three balls, of which the outer two do not overlap, and one apart."""
    chain = [ball(0.5, (x, 0, 0), fine=8) for x in (0.0, 1.6, 0.8)]
    bodies = Bodies([*chain, ball(0.5, (5, 0, 0), fine=8)])
    assert bodies.number[0] == bodies.number[1] == bodies.number[2] != bodies.number[3]
    np.testing.assert_allclose(bodies.high[bodies.number[0]][0] - bodies.low[bodies.number[0]][0], 2.6, atol=0.2)
    assert not len(Bodies([]).low)
    assert (Bodies([ball(0.1, (x, 0, 0), fine=4) for x in range(80)]).number == -1).all()


def test_segments_come_into_boxes_where_points_of_them_do():
    rng = np.random.default_rng(2)
    start, stop = rng.uniform(-1, 1, (2, 3, 20_000)).astype(np.float32)
    stop[:, :300] = start[:, :300]  # no length
    stop[0, 300:600] = start[0, 300:600]  # along a face
    low, high = np.array([[-0.3, -0.2, 0.1], [0.5, 0.5, 0.5]]), np.array([[0.1, 0.4, 0.3], [0.9, 0.6, 0.9]])
    found = crossing(start, stop, low, high, 2.0)
    inside = np.zeros(len(found), bool)
    for t in np.linspace(0, 1, 400):
        point = (start + t * (stop - start)).T[:, None]
        inside |= ((point >= low) & (point <= high)).all(2).any(1)
    assert not (inside & ~found).any() and (found & ~inside).mean() < 0.01 and 0.02 < inside.mean() < 0.5


def test_ways_from_elsewhere_are_written_down_and_those_in_a_body_are_not():
    """Glass over a table: one way in and the ways out, that end where they land; beside a second body all of them."""
    table, glass = floor(4.0, 0.0), slab((-1, -1, 0.5), (1, 1, 1.0))
    for others, least in (((), 1), ((ball(0.3, (0, 0, 0.2), fine=12),), 2)):
        where = scene(glass, *others, receivers=(table,))
        surfaces = Surfaces(where, np.ones(3))
        bodies = Bodies(where.casters)
        number = np.full(surfaces.water + 1, -1)
        number[surfaces.solid : -1] = np.repeat(bodies.number, [len(c.triangles) for c in where.casters])
        trail = Trail(surfaces, number, 2)
        origin = np.array([[0.02, 0.013, 2.0], [1.4, 1.0, 2.0]]).T
        rays = Rays.of(origin, np.tile([[0.0], [0], [-1]], 2), 1)
        follower = Follower(surfaces, 3)
        list(follower.ends(rays, trail=trail))
        photon, start, stop = trail.take()
        centre = surfaces.tracer.centre
        assert (photon == 1).sum() == 1, "past the glass to the table"
        np.testing.assert_allclose((stop[:, photon == 1].T + centre)[0], [1.4, 1.0, 0], atol=1e-5)
        np.testing.assert_allclose((start[:, 0] + centre), origin[:, 0], atol=1e-5)
        assert least < (photon == 0).sum() < follower.cast - 1
        ends = stop[2] + centre[2]
        assert (np.abs(ends[photon == 0]) < 1e-5).any() and not trail.doubtful.any()
