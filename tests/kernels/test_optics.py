"""Snell and Fresnel against the textbook."""

import numpy as np
import pytest
from waves import transmitted

from dapple.kernels.optics import cosine_refracted, fresnel_transmittance, sun_frame
from dapple.kernels.splat.photons import bend


@pytest.mark.parametrize("degrees", [0.0, 5.0, 30.0, 60.0, 85.0, 89.9])
@pytest.mark.parametrize("eta", [1.1, 1.333, 1.5, 2.4])
def test_fresnel_is_the_textbooks(degrees, eta):
    cos_i = np.cos(np.radians(degrees))
    assert fresnel_transmittance(cos_i, cosine_refracted(cos_i, eta), eta) == pytest.approx(
        transmitted(cos_i, eta), abs=1e-12
    )


def test_brewster_angle_reflects_no_p():
    eta = 1.333
    cos_i = np.cos(np.arctan(eta))
    cos_t = cosine_refracted(cos_i, eta)
    r_s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    assert fresnel_transmittance(cos_i, cos_t, eta) == pytest.approx(1 - r_s**2 / 2, abs=1e-14)


def test_refracted_rays_obey_snell_and_stay_in_the_plane():
    rng = np.random.default_rng(1)
    normal = rng.normal(size=(500, 3)) * 0.5 + [0, 0, 2]
    d = np.array([0.3, -0.2, -1]) / np.linalg.norm([0.3, -0.2, -1])
    # The normals are interpolated ones, not of unit length.
    g, passed = bend(-normal @ d, (normal**2).sum(1), 1.333)
    t = d / 1.333 + g[:, None] * normal
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    np.testing.assert_allclose(passed, [transmitted(c) for c in -normal @ d], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(t, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(np.cross(t, normal) * 1.333, np.cross(np.tile(d, (500, 1)), normal), atol=1e-14)
    assert ((t * normal).sum(1) < 0).all()


@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 0, 1), (1, 0, 0), (0.3, -0.4, -0.87)])
def test_sun_frame_turns_light_to_minus_z(direction):
    d = np.array(direction) / np.linalg.norm(direction)
    frame = sun_frame(d)
    np.testing.assert_allclose(frame @ d, [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1)
