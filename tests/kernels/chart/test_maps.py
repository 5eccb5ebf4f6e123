"""What errors of light are, on texels of which each error can be told by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from dapple.kernels.chart.maps import Maps, light_of


def grey(*values):
    """Light (K,3), alike in all channels."""
    return np.repeat(np.array(values, float)[:, None], 3, axis=1)


@pytest.fixture
def truth():
    """Three texels of 1, 1 and 2 m2; the first is one receiver, the others the next."""
    return Maps(grey(1, 2, 3), np.array([1.0, 1.0, 2.0]), (1,))


def test_no_error_is_none(truth):
    for error in (truth.error, truth.error_by_mean, truth.mean_error, truth.energy):
        assert error(truth.light) == 0.0


def test_errors_of_one_texel(truth):
    found = grey(1, 2, 4)  # the last is 1 W/m2 too bright, on half of the area
    assert truth.error(found) == pytest.approx(2 / (1 + 4 + 2 * 9))
    assert truth.error_by_mean(found) == pytest.approx((2 / 4) / (9 / 4) ** 2)
    assert truth.mean_error(found) == pytest.approx(2 / 9)
    assert truth.energy(found) == pytest.approx(2 / 9)


def test_energy_has_a_sign_and_the_others_none(truth):
    found = grey(1, 3, 2)
    assert truth.energy(found) == pytest.approx(-1 / 9)
    assert truth.mean_error(found) == pytest.approx(3 / 9)


def test_parts_are_receivers(truth):
    found = grey(2, 2, 4)
    assert truth.mean_error(found, part=0) == pytest.approx(1.0)
    assert truth.mean_error(found, part=1) == pytest.approx(2 / 8)


def test_only_what_is_seen_counts(truth):
    found = grey(5, 2, 4)
    seen = np.array([False, True, True])
    assert truth.error(found, seen=seen) == pytest.approx(2 / (4 + 18))
    assert truth.mean_error(found, part=1, seen=np.array([True, False, True])) == pytest.approx(2 / 6)


def test_all_too_bright_by_a_part(truth):
    assert truth.error(1.1 * truth.light) == pytest.approx(0.01)
    assert truth.energy(1.1 * truth.light) == pytest.approx(0.1)


def test_light_where_there_is_none():
    dark = Maps(grey(0, 0), np.ones(2), ())
    assert dark.error(grey(0, 0)) == 0.0
    assert dark.error(grey(0, 1)) == np.inf


def test_light_of_images_is_that_of_the_texels_and_round_again():
    texels = [SimpleNamespace(texel=np.array([1, 2]), area=np.ones(2)), SimpleNamespace(texel=[3], area=np.ones(1))]
    images = [np.arange(12.0).reshape(2, 2, 3), np.arange(12.0, 24.0).reshape(2, 2, 3)]
    light = light_of(texels, images)
    assert light.tolist() == [[3, 4, 5], [6, 7, 8], [21, 22, 23]]
    maps = Maps.of(texels, light)
    assert maps.cuts == (2,)
    assert maps.weight.tolist() == [1, 1, 1]
