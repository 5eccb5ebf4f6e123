"""Flux that is left on a sheet is all there, and lies where the area lies."""

import numpy as np
import pytest

from dapple.kernels.splat.sheet import Sheet


def test_triangles_keep_their_flux_whichever_way_they_turn():
    rng = np.random.default_rng(1)
    x, y = rng.random((2, 300, 3)) * 8
    x[:100], y[:100] = x[:100, :1] + 0.01 * x[:100], y[:100, :1] + 0.01 * y[:100]  # small ones, most inside a texel
    x[100:110], y[100:110] = x[100:110, :1], y[100:110, :1]  # and some without area
    x, y = np.clip(x, 0, 8), np.clip(y, 0, 8)
    plane, flux = rng.integers(0, 3, 300), rng.random(300)
    sheet = Sheet(np.array([0, 1, 0]), 2, 8)
    sheet.add_triangles(plane, x.T, y.T, flux[None])
    images = sheet.flux().reshape(2, 64)
    assert images[0].sum() == pytest.approx(flux[plane != 1].sum(), rel=1e-9)
    assert images[1].sum() == pytest.approx(flux[plane == 1].sum(), rel=1e-9)
    assert images.min() > -1e-9


def test_even_over_the_area():
    sheet = Sheet(np.array([0]), 1, 4)
    square = np.array([[0, 4, 4], [0, 4, 0]], float), np.array([[0, 0, 4], [0, 4, 4]], float)
    sheet.add_triangles(np.zeros(2, int), *(v.T for v in square), np.array([[8.0, 8.0]]))
    np.testing.assert_allclose(sheet.flux()[0], np.ones(16), atol=1e-12)


def test_nothing_and_points():
    sheet = Sheet(np.array([0]), 1, 4)
    assert not sheet.flux().any()
    sheet.add_points(
        np.zeros(3, int), np.array([0.0, 4.0, 2.5]), np.array([0.0, 4.0, 1.5]), np.array([[1.0, 2.0, 3.0]])
    )
    assert sheet.flux().reshape(4, 4)[[0, 3, 1], [0, 3, 2]].tolist() == [1, 2, 3]
