"""Small ellipses: by blocks of cells, against a loop over cells, and what borders do."""

import numpy as np
import pytest

from dapple.kernels.disc.kernels import kernel, representatives
from dapple.kernels.disc.near import blur_near

ROWS, COLUMNS = 20, 27


def everywhere(moments):
    """home and moments (3,K) of an image of which every texel has its own, all alike."""
    home = np.arange(ROWS * COLUMNS).reshape(ROWS, COLUMNS)
    return home, np.tile(np.array(moments)[:, None], ROWS * COLUMNS)


def cells(grain, seed=0):
    return np.random.default_rng(seed).random((1, grain * ROWS, grain * COLUMNS))


@pytest.mark.parametrize("grain", [1, 2, 3])
def test_it_is_the_kernel_on_cells_summed_over_texels(grain):
    moments = 0.5, 0.3, 0.1
    flux = np.zeros((1, grain * ROWS, grain * COLUMNS))
    inside = slice(5 * grain, -5 * grain)
    flux[:, inside, inside] = cells(grain)[:, inside, inside]
    shares = kernel(np.array(moments) * grain**2)
    reach = len(shares) // 2
    wanted = np.zeros_like(flux)
    for (down, right), share in np.ndenumerate(shares):
        wanted += share * np.roll(flux, (down - reach, right - reach), axis=(1, 2))
    wanted = wanted.reshape(1, ROWS, grain, COLUMNS, grain).sum((2, 4))
    found = blur_near(flux, np.zeros((ROWS, COLUMNS), int), *everywhere(moments), grain)
    np.testing.assert_allclose(found, wanted, atol=1e-13)


@pytest.mark.parametrize("grain", [1, 2, 3])
@pytest.mark.parametrize("slant", [0.0, 0.3])
def test_even_light_stays_even_up_to_borders_along_the_rows(grain, slant):
    """But for corners, where a slanted ellipse and its mirror image differ."""
    chart = np.zeros((ROWS, COLUMNS), int)
    chart[:, 12:] = 1
    found = blur_near(np.ones((1, grain * ROWS, grain * COLUMNS)), chart, *everywhere((1.2, 0.7, slant)), grain)
    even = found[0, 3:-3] if slant else found[0]
    np.testing.assert_allclose(even, grain**2, rtol=1e-12)


def test_no_light_is_lost_and_none_crosses_to_another_chart():
    """Charts of any shape, texels on none among them, and ellipses that grow along the rows."""
    y, x = np.mgrid[:ROWS, :COLUMNS]
    chart = np.where((x - 9) ** 2 + (y - 8) ** 2 < 40, 0, np.where(x + y > 30, 1, -1))
    home, moments = everywhere((1.0, 0.8, 0.4))
    moments = moments * np.linspace(0.1, 1.5, ROWS * COLUMNS)
    flux = cells(2)
    found = blur_near(flux, chart, home, moments, 2)
    before = flux.reshape(1, ROWS, 2, COLUMNS, 2).sum((2, 4))
    for own in (0, 1):
        assert found[0][chart == own].sum() == pytest.approx(before[0][chart == own].sum(), rel=1e-12)
        assert not np.allclose(found[0][chart == own], before[0][chart == own], rtol=1e-2)
    np.testing.assert_allclose(found[0][chart < 0], before[0][chart < 0], rtol=1e-12)


def test_the_blend_of_representatives_has_every_moment():
    """Where moments vary along one direction, as with depth, and along two."""
    rng = np.random.default_rng(1)
    depth, turn = rng.random((2, 500))
    for moments, most in (
        (np.outer([1.0, 0.6, 0.3], depth**2), 5),
        (np.stack([depth, 0.6 * depth + 0.3 * turn, 0.1 * turn]), 25),
    ):
        kinds = list(representatives(moments))
        assert 1 < len(kinds) <= most
        np.testing.assert_allclose(sum(weight for _, weight in kinds), 1, atol=1e-9)
        blend = sum(own[:, None] * weight for own, weight in kinds)
        np.testing.assert_allclose(blend, moments, atol=0.12)
