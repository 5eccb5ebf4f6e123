"""Beer and Lambert's law along the bent way, and where the watts go."""

from dataclasses import replace

import numpy as np
import pytest
from waves import OBLIQUE, calm, five_sines, flat, floor, pool, quad, transmitted

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Point, Settings
from dapple.kernels.splat.photon_splat import solve as splat
from dapple.kernels.walk.conic_walk import solve as walk

SIGMA = np.array([0.6, 0.2, 0.05])
LAMP = Point("Lamp", np.array([0.2, 0.1, 3.0]), np.array([1.0, 1.0, 1.0]))
either = pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])
lit = pytest.mark.parametrize("light", [None, LAMP], ids=["sun", "lamp"])


def bake(scene, resolution=32, tolerance=1e-4, points=False, solve=splat):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(tolerance=tolerance, points=points))


def blue(shape=flat, sigma_a=SIGMA, light=None, **kind):
    scene = pool(shape, **kind)
    return replace(scene, sigma_a=np.asarray(sigma_a, float), lights=(light,) if light else scene.lights)


@pytest.mark.parametrize("depth", [0.3, 1.5])
@either
def test_flat_water_absorbs_exponentially_along_the_bent_ray(depth, points):
    scene = blue(quads=24, side=12.0, receivers=[floor(z=1.5 - depth)])
    image = bake(scene, points=points).images[0]
    cos_i = 1 / np.linalg.norm(OBLIQUE)
    cos_t = np.sqrt(1 - (1 - cos_i**2) / 1.333**2)
    expected = cos_i * transmitted(cos_i) * np.exp(-SIGMA * depth / cos_t)
    np.testing.assert_allclose(image.mean((0, 1)), expected, rtol=5e-3 if points else 1e-9)
    if not points:
        np.testing.assert_allclose(image, np.broadcast_to(expected, image.shape), rtol=1e-9)


@lit
@either
def test_what_is_absorbed_is_booked(light, points):
    """Under floor and walls of every slant, nothing is lost unsaid; red loses most."""
    wall = quad("Wall", [[1.5, -2, 0], [1.5, 2, 0], [1.9, 2, 1.3], [1.9, -2, 1.3]])
    d = bake(blue(five_sines, light=light, quads=32, receivers=[floor(), wall]), 32, 1e-3, points).diagnostics
    total = sum(d.flux_received.values()) + sum(d.flux_lost.values())
    np.testing.assert_allclose(total, d.flux_in, rtol=1e-9)
    red, green, blue_ = d.flux_lost["absorbed"]
    assert red > green > blue_ > 0
    clear = bake(blue(five_sines, 0 * SIGMA, light, quads=32, receivers=[floor(), wall]), 32, 1e-3, points).diagnostics
    assert "absorbed" not in clear.flux_lost
    np.testing.assert_allclose(d.flux_lost["reflected"], clear.flux_lost["reflected"], rtol=1e-3)


@lit
def test_points_and_beams_agree_over_waves(light):
    scene = blue(five_sines, light=light, quads=48)
    beams, points = bake(scene, 32, 1e-3), bake(scene, 32, 1e-3, points=True)
    difference = ((beams.images[0] - points.images[0]) ** 2).mean() / points.images[0].mean() ** 2
    assert difference < 2 * (points.diagnostics.estimated_error + beams.diagnostics.estimated_error)
    for name, watts in points.diagnostics.flux_received.items():
        np.testing.assert_allclose(beams.diagnostics.flux_received[name], watts, rtol=2e-3)


def test_beams_and_the_walk_absorb_alike():
    """Two methods that share no sum, on calm water: the light that is left, in all and within the tolerance."""
    beams, paths = (bake(blue(calm, quads=64), 32, 1e-5, solve=solve).images[0] for solve in (splat, walk))
    np.testing.assert_allclose(paths.mean((0, 1)), beams.mean((0, 1)), rtol=2e-3)
    assert (((paths - beams)[2:-2, 2:-2] ** 2).mean((0, 1)) < 1e-4 * beams.mean((0, 1)) ** 2).all()


def test_grey_water_and_lamps_of_one_colour_need_one_channel():
    grey = bake(blue(five_sines, [0.3, 0.3, 0.3], quads=24)).images[0]
    np.testing.assert_array_equal(grey[..., 0], grey[..., 2])
    red = replace(LAMP, intensity=np.array([2.0, 0.0, 0.0]))
    only = bake(blue(five_sines, light=red, quads=24)).images[0]
    assert only[..., 0].any() and not only[..., 1:].any()
    white = bake(blue(five_sines, light=LAMP, quads=24)).images[0]
    assert ((only[..., 0] - 2 * white[..., 0]) ** 2).mean() < 1e-4 * only[..., 0].mean() ** 2
