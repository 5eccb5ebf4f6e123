"""The comparators of the benchmarks find what the walk finds, where one path leads to every point."""

from dataclasses import replace

import numpy as np
import pytest
from bench.manifold import Manifold, mnee, sms_biased, sms_unbiased
from waves import calm, five_sines, floor, pool

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Point


def manifold(shape, side=12, light=None):
    scene = pool(shape, quads=48, receivers=[floor(side=2.0)])
    scene = replace(scene, lights=(light,)) if light else scene
    texels = rasterise(scene.receivers[0], side)
    return Manifold(scene, texels.positions, texels.normals)


def every_path(one):
    """Irradiance (K,) in red of all paths, and how many (K,) there are."""
    paths = one.paths.to(one.points, one.normals)
    assert not paths.missing.any()
    watts = one.paths.irradiance(paths.passed, paths.density, paths.length)[:, 0] * paths.visible
    count = len(one.points)
    return np.bincount(paths.point, watts, count), np.bincount(paths.point, minlength=count)


@pytest.mark.parametrize("light", [None, Point("Lamp", np.array([0.3, 0.2, 4.5]), np.array([9.0, 8.0, 7.0]))])
def test_all_find_the_one_path(light):
    one = manifold(calm, light=light)
    true, number = every_path(one)
    assert (number == 1).all()
    by_newton, found = mnee(one)
    assert found.all()
    np.testing.assert_allclose(by_newton, true, rtol=1e-4)
    sampled, count = sms_biased(one, 12, np.random.default_rng(0))
    assert (count <= 1).all() and count.mean() > 0.9
    np.testing.assert_allclose(sampled[count == 1], true[count == 1], rtol=1e-4)


def test_biased_sampling_finds_more_with_more_starts_and_no_path_twice():
    one = manifold(five_sines)
    _, number = every_path(one)
    assert number.max() >= 3
    few, many = (sms_biased(one, starts, np.random.default_rng(1))[1] for starts in (2, 48))
    assert few.sum() < many.sum() <= number.sum() and (many <= number).all()
    assert many.sum() > 0.9 * number.sum()


def test_unbiased_sampling_is_so():
    """The mean over samples and points is the light of all paths, within four of its standard errors."""
    one = manifold(five_sines, side=8)
    true, _ = every_path(one)
    means = []
    for seed in range(12):
        light, cut = sms_unbiased(one, 1, np.random.default_rng(seed))
        assert cut < 0.01
        means.append(light.mean())
    error = np.std(means, ddof=1) / np.sqrt(len(means))
    assert abs(np.mean(means) - true.mean()) < 4 * error
    assert error < 0.2 * true.mean()


def test_starts_near_by_find_every_path_with_fewer():
    one = manifold(five_sines)
    true, number = every_path(one)
    near, count = sms_biased(one, 24, np.random.default_rng(1), one.near)
    far = sms_biased(one, 24, np.random.default_rng(1))[1]
    assert (count <= number).all()
    assert count.sum() > 0.97 * number.sum() > far.sum()
    same = count == number
    np.testing.assert_allclose(near[same], true[same], rtol=1e-4)
