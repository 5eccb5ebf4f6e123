"""The sun's disc: one convolution against the sum over many suns of no width."""

from dataclasses import replace

import numpy as np
import pytest
from waves import OBLIQUE, five_sines, flat, floor, pool, quad

from dapple.kernels.disc import disc, kernels
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Settings
from dapple.kernels.splat.photon_splat import solve

SUNS = 60
WIDE = np.radians(1.5)


def bake(scene, resolution=96, tolerance=1e-3, **settings):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=tolerance, **settings))


def with_disc(scene, angle=WIDE):
    return replace(scene, lights=tuple(replace(sun, angle=angle) for sun in scene.lights))


def with_many_suns(scene, angle=WIDE):
    sun = replace(scene.lights[0], angle=angle, irradiance=scene.lights[0].irradiance / SUNS)
    return replace(scene, lights=tuple(disc.within_disc(sun, SUNS, np.random.default_rng(5))))


def error(images, reference):
    difference = sum(((a - b) ** 2).sum() for a, b in zip(images, reference, strict=True))
    return difference / sum((b**2).sum() for b in reference)


SLOPE = quad("Slope", [[-2, -2, 0.2], [2, -2, 0.2], [2, 2, 1.2], [-2, 2, 1.2]])
WALL = quad("Wall", [[-2, 2, 0], [2, 2, 0], [2, 2, 1.2], [-2, 2, 1.2]], (0.1, 0.1), (0.9, 0.5))


@pytest.mark.parametrize("direction", [(0, 0, -1), OBLIQUE, (0.8, 0.3, -1)])
@pytest.mark.parametrize("receivers", [[floor()], [SLOPE], [floor(), WALL]], ids=["floor", "slope", "floor and wall"])
def test_it_is_the_sum_over_many_suns(direction, receivers):
    """Depth that varies, slanted light, several receivers: most of what the disc changes is right."""
    scene = pool(lambda x, y: five_sines(x, y, 0.7), quads=64, direction=direction, receivers=receivers, side=7.0)
    many, one = bake(with_many_suns(scene)), bake(with_disc(scene))
    changed, left = error(bake(scene).images, many.images), error(one.images, many.images)
    assert left < changed / 4


def test_it_keeps_the_energy_whatever_the_depth():
    scene = pool(quads=48, receivers=[floor(), WALL], side=4.0)
    blurred, sharp = bake(with_disc(scene)).diagnostics, bake(scene).diagnostics
    for name, flux in sharp.flux_received.items():
        np.testing.assert_allclose(blurred.flux_received[name], flux, rtol=2e-6)


def test_even_light_stays_even_up_to_the_rim():
    scene = with_disc(pool(flat, quads=24, receivers=[SLOPE], side=9.0))
    image = bake(scene).images[0][..., 0]
    np.testing.assert_allclose(image, image.mean(), rtol=0.01)
    np.testing.assert_allclose(image[8:-8, 8:-8], image[48, 48], rtol=2e-3)


def test_without_an_angle_nothing_changes():
    scene = pool(quads=24)
    np.testing.assert_array_equal(bake(with_disc(scene, 0.0)).images[0], bake(scene).images[0])
    np.testing.assert_array_equal(bake(with_disc(scene, 1e-6)).images[0], bake(scene).images[0])


def test_points_from_all_over_the_disc_agree():
    scene = with_disc(pool(quads=48))
    beams, points = bake(scene, 48), bake(scene, 48, 3e-3, points=True)
    off = ((beams.images[0] - points.images[0]) ** 2).mean() / points.images[0].mean() ** 2
    assert off < 2 * (beams.diagnostics.estimated_error + points.diagnostics.estimated_error)


def test_light_does_not_leave_its_chart():
    """Two floors side by side in UV, one of them in the dark: nothing spills over."""
    lit = quad("Both", [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], (0.0, 0.0), (0.5, 1.0))
    far = quad("Far", [[50, -2, 0], [54, -2, 0], [54, 2, 0], [50, 2, 0]], (0.5, 0.0), (1.0, 1.0))
    joined = replace(
        lit,
        positions=np.concatenate([lit.positions, far.positions]),
        triangles=np.concatenate([lit.triangles, far.triangles + 4]),
        uvs=np.concatenate([lit.uvs, far.uvs]),
    )
    image = bake(with_disc(pool(quads=32, receivers=[joined])), 64).images[0]
    assert image[:, :32].min() > 0 and image[:, 33:].max() < 1e-12


def test_dark_stays_dark_and_none_is_negative():
    """Half of a slope lies outside the light: large ellipses, blended by transforms, leave nothing there."""
    scene = with_disc(pool(quads=32, receivers=[SLOPE], side=2.0), np.radians(6.0))
    image = bake(scene).images[0]
    assert image.min() == 0 and (image == 0).mean() > 0.2


def test_a_few_ellipses_along_grazed_sides_do_not_speak_for_all():
    """One texel in fifty has an ellipse a hundred texels long: no more than that part of the map is as wrong as can be,
    though the mean of the squares would say so of all of it. And of the cells, only it asks for none."""
    short, long = np.full(49, 0.4), np.full(1, 100.0)
    both = np.concatenate([short, long])
    rest, most = disc._rest(both, 10_000), disc._MOST_RIM
    assert disc._rest(short, 10_000) < rest < disc._rest(short, 10_000) + most / 50
    assert disc._rest(np.sqrt([(both**2).mean()]), 10_000) > 10 * rest
    for grain in (1, 2, 3, 4):
        assert disc._grid_error(both, grain) == pytest.approx(0.98 * disc._grid_error(short, grain), rel=1e-3)


@pytest.mark.parametrize("size", [0.05, 0.2, 0.7, 3.0, 12.0])
def test_kernels_have_the_moments_that_are_asked(size):
    covariance = size * np.array([[1.0, 0.3], [0.3, 0.6]])
    kernel = kernels.kernel((covariance[0, 0], covariance[1, 1], covariance[0, 1]))
    assert kernel.sum() == pytest.approx(1, abs=1e-12) and kernel.min() > -1e-15
    np.testing.assert_allclose(kernels.second_moments(kernel), covariance, rtol=0.03, atol=1e-3)
    np.testing.assert_allclose(kernel, kernel[::-1, ::-1], atol=1e-12)
