"""The embreex adapter against planes."""

import numpy as np
import pytest
from waves import floor

from dapple.kernels.rays import MISS, Tracer, soup


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
