"""Cubics between corners: on spheres and planes, the same from both sides of an edge."""

import numpy as np
import pytest

from dapple.kernels.surface.hermite import between_corners

RADIUS = 1.5


def sphere(directions):
    """Corners (3,c,n), normals and turns of a sphere at directions (3,c,n)."""
    n = directions / np.linalg.norm(directions, axis=0)
    return RADIUS * n, n, (np.eye(3)[:, :, None, None] - n[:, None] * n) / RADIUS


def some(corners, size, count=40, seed=0):
    """Directions of small triangles or edges."""
    rng = np.random.default_rng(seed)
    return rng.standard_normal((3, 1, count)) + size * rng.standard_normal((3, corners, count))


def shares(corners, count=9):
    return np.random.default_rng(1).dirichlet(np.ones(corners), count).T


@pytest.mark.parametrize("corners", [2, 3])
def test_they_near_a_sphere_with_the_fourth_power(corners):
    off = []
    for size in (0.1, 0.05):
        position, normal = np.split(between_corners(*sphere(some(corners, size)), shares(corners)), 2)
        np.testing.assert_allclose(normal, position / RADIUS, atol=1e-12)  # they are scaled copies at all corners
        off.append(np.abs(np.linalg.norm(position, axis=0) - RADIUS).max())
    assert off[0] > 8 * off[1] and off[1] < 1e-3


def test_the_middle_of_an_arc_is_on_its_circle():
    """The length of the tangents is that for which it is, to rounding."""
    ends = np.array([[[1.0], [np.cos(0.9)]], [[0.0], [np.sin(0.9)]], [[0.0], [0.0]]])
    middle = between_corners(*sphere(ends), np.full((2, 1), 0.5))[:3, 0, 0]
    np.testing.assert_allclose(middle, RADIUS * np.array([np.cos(0.45), np.sin(0.45), 0]), atol=1e-12)


def test_corners_are_where_they_were():
    positions, normals, turns = sphere(some(3, 0.1))
    out = between_corners(positions, normals, turns, np.eye(3))
    np.testing.assert_allclose(out, np.concatenate([positions, normals]).transpose(0, 2, 1), atol=1e-14)


def test_an_edge_of_a_triangle_is_that_edge():
    positions, normals, turns = sphere(some(3, 0.2))
    along = np.stack([np.linspace(0, 1, 5), 1 - np.linspace(0, 1, 5)])
    edge = between_corners(positions[:, :2], normals[:, :2], turns[:, :, :2], along)
    in_triangle = between_corners(positions, normals, turns, np.concatenate([along, np.zeros((1, 5))]))
    np.testing.assert_allclose(edge, in_triangle, atol=1e-14)
    back = between_corners(positions[:, 1::-1], normals[:, 1::-1], turns[:, :, 1::-1], along[::-1])
    np.testing.assert_allclose(edge, back, atol=1e-14)


def test_a_plane_stays_flat_and_points_coincide_safely():
    positions = np.random.default_rng(2).standard_normal((3, 3, 20)) * np.array([1, 1, 0])[:, None, None]
    positions[:, 1, 0] = positions[:, 0, 0]
    normals = np.zeros_like(positions)
    normals[2] = 1
    out = between_corners(positions, normals, np.zeros((3, 3, 3, 20)), shares(3))
    np.testing.assert_allclose(out[2], 0, atol=1e-14)
    assert np.isfinite(out).all()
