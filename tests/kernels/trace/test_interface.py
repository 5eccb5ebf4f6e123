"""Fresnel from both sides, total reflection and Schlick's mirrors, against closed forms."""

import numpy as np
import pytest
from waves import transmitted

from dapple.kernels.trace.interface import fresnel, reflected, refracted, schlick


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 70.0, 89.0])
def test_what_enters_leaves_alike(angle):
    """The share that passes is the same both ways, and that of the textbook's angles."""
    cos_i = np.array([np.cos(np.radians(angle))])
    cos_t, turned = fresnel(cos_i, 1 / 1.5)
    back, turned_back = fresnel(cos_t, 1.5)
    assert 1 - turned[0] == pytest.approx(transmitted(cos_i[0], 1.5), abs=1e-9)
    assert back[0] == pytest.approx(cos_i[0], abs=1e-12) and turned_back[0] == pytest.approx(turned[0], abs=1e-12)


def test_all_is_turned_back_beyond_the_critical_angle():
    critical = np.arcsin(1 / 1.5)
    cos_t, turned = fresnel(np.cos(critical + np.array([-1e-6, 1e-9, 0.1, 0.5])), 1.5)
    assert 0.9 < turned[0] < 1 and cos_t[0] > 0
    np.testing.assert_array_equal(turned[1:], 1)
    np.testing.assert_array_equal(cos_t[1:], 0)


def test_at_brewsters_angle_only_one_polarisation_is_turned_back():
    theta = np.arctan(1.5)
    _, turned = fresnel(np.array([np.cos(theta)]), 1 / 1.5)
    assert turned[0] == pytest.approx(np.sin(2 * theta - np.pi / 2) ** 2 / 2, rel=1e-12)


def test_equal_media_change_nothing():
    cos_i = np.linspace(0.01, 1, 9)
    cos_t, turned = fresnel(cos_i, 1.0)
    np.testing.assert_allclose(cos_t, cos_i, rtol=1e-12)
    np.testing.assert_allclose(turned, 0, atol=1e-12)


def test_directions_obey_snell_and_the_mirror():
    rng = np.random.default_rng(3)
    direction = rng.normal(size=(3, 50))
    direction /= np.linalg.norm(direction, axis=0)
    normal = np.array([[0.0], [0.0], [1.0]]) * -np.sign(direction[2])
    cos_i = np.abs(direction[2])
    cos_t, _ = fresnel(cos_i, 1 / 1.5)
    bent = refracted(direction, normal, cos_i, cos_t, 1 / 1.5)
    np.testing.assert_allclose(bent[:2], direction[:2] / 1.5, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(bent, axis=0), 1, rtol=1e-12)
    np.testing.assert_allclose(reflected(direction, normal, cos_i), direction * [[1], [1], [-1]], atol=1e-14)


def test_a_mirror_is_its_colour_along_the_normal_and_f90_at_grazing():
    f0, f90 = np.array([[0.9], [0.6], [0.2]]), np.ones((3, 1))
    share = schlick(np.array([1.0, 0.0, 0.5]), f0, f90)
    np.testing.assert_allclose(share[:, 0], f0[:, 0])
    np.testing.assert_allclose(share[:, 1], 1)
    np.testing.assert_allclose(share[:, 2], f0[:, 0] + (1 - f0[:, 0]) / 32)
