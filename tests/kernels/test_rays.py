"""The embreex adapter against planes."""

import numpy as np
import pytest
from waves import floor

from dapple.kernels.rays import MISS, SLOW, Tracer, soup


@pytest.mark.parametrize("far", [0.0, 1e5, 1e7])
def test_first_hit_far_from_the_origin(far):
    low, high = floor(z=0.0), floor(z=1.0, side=2.0)
    positions, triangles = soup((low, high))
    tracer = Tracer(positions + far, triangles)
    origins = np.array([[0.5, 0.2, 2.0], [1.7, 0.3, 2.0], [3.0, 0.0, 2.0]]) + far
    hit = tracer.first(origins, np.tile([0, 0, -1.0], (3, 1)))
    assert hit[0] in (2, 3) and hit[1] in (0, 1) and hit[2] == MISS


def test_blocked_stops_short_of_the_surface_that_the_ray_ends_on():
    tracer = Tracer(*soup((floor(z=0.0), floor(z=1.0, side=2.0))))
    origins = np.array([[0.5, 0.2, 2.0], [1.7, 0.3, 2.0]])
    down = np.tile([0, 0, -1.0], (2, 1))
    np.testing.assert_array_equal(tracer.blocked(origins, down, np.array([2.0, 2.0])), [True, False])
    np.testing.assert_array_equal(tracer.blocked(origins, down), [True, True])
    np.testing.assert_array_equal(tracer.blocked(origins, -down), [False, False])


def test_a_tiny_mesh_far_down_does_not_block_its_own_rays():
    tracer = Tracer(*soup((floor(side=1e-4, z=-50.0),)))
    origins = np.array([[0.3, 0.2, 2.0], [0.0, 1e-5, 2.0]])
    ray = np.array([1e-5, 2e-5, -50.0]) - origins
    length = np.linalg.norm(ray, axis=1)
    assert not tracer.blocked(origins, ray / length[:, None], length).any()
    assert tracer.blocked(origins, ray / length[:, None], length * 1.01).all()


def test_nothing_to_hit():
    tracer = Tracer(*soup(()))
    assert tracer.first(np.zeros((2, 3)), np.ones((2, 3))).tolist() == [MISS, MISS]
    assert not tracer.blocked(np.zeros((2, 3)), np.ones((2, 3))).any()


@pytest.mark.skipif(bool(SLOW), reason="embree alone has an order of search")
def test_hits_near_an_edge_are_told_from_others():
    """A floor of two triangles: their diagonal, its rim, and what is a hair beside them."""
    tracer, off = Tracer(*soup((floor(z=0.0, side=2.0),))), np.array([0, 1e-8, 1e-5, 0.3])
    up = np.full(len(off), 2.0)
    for origins in (
        np.stack([off - 0.25, -off - 0.25, up], 1),  # the diagonal, from one corner to the other
        np.stack([1 - off, off / 3 + 0.1, up], 1),
    ):
        triangle, distance, doubtful = tracer.hits(origins, np.tile([0, 0, -1.0], (len(off), 1)))
        met = triangle != MISS
        np.testing.assert_array_equal(triangle, tracer.first(origins, np.tile([0, 0, -1.0], (len(off), 1))))
        np.testing.assert_allclose(distance[met], 2.0, rtol=1e-6)
        assert (doubtful[:2] | ~met[:2]).all() and met[2:].all() and not doubtful[2:].any()
    triangle, distance, doubtful = tracer.hits(np.array([[5.0, 0, 2]]), np.array([[0, 0, -1.0]]))
    assert triangle[0] == MISS and np.isinf(distance[0]) and not doubtful[0]
