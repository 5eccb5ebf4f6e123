"""Point and spot lamps: all paths of light that spreads from a point, against beams and against still water."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, flat, floor, pool, transmitted

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Point, Settings, Spot
from dapple.kernels.splat import photon_splat
from dapple.kernels.status import Status
from dapple.kernels.walk.conic_walk import solve

ABOVE = np.array([0.4, -0.3, 3.0])


def point():
    return Point("Bulb", ABOVE, np.array([3.0, 2.0, 1.0]))


def spot():
    return Spot("Spot", ABOVE, np.ones(3), half_angle=np.radians(25), blend=0.5)


def lit_by(scene, lamp):
    return replace(scene, lights=(lamp,))


def test_under_a_lamp_still_water_gives_the_closed_form():
    """On the axis light from height a, through depth h, spreads as if from (a + h / eta): E = I T / (a + h / eta)^2."""
    eta, height, depth = 1.333, 1.5, 1.5
    lamp = Point("Bulb", np.array([0, 0, 1.5 + height]), np.ones(3))
    scene = lit_by(pool(flat, quads=33, side=4.0, receivers=[floor(side=0.01)]), lamp)
    answer = solve(scene, [rasterise(scene.receivers[0], 1)], Settings(tolerance=1e-6))
    expected = transmitted(1.0) / (height + depth / eta) ** 2
    assert answer.images[0][0, 0, 0] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("lamp", [point, spot])
def test_under_a_lamp_storms_agree_with_exact_coverage(lamp):
    scene = lit_by(pool(lambda x, y: five_sines(x, y, 1.5), quads=64, side=8.0), lamp())
    texels = [rasterise(scene.receivers[0], 48)]
    answer = solve(scene, texels, Settings(tolerance=0.004))
    beams = photon_splat.solve(scene, texels, Settings(tolerance=1e-6))
    image, reference = answer.images[0], beams.images[0]
    stated = answer.diagnostics.estimated_error
    assert stated < 0.004 and not any("lamp" in s for s in answer.diagnostics.left_out)
    error = ((image - reference)[..., 0] ** 2).mean() / reference[..., 0].mean() ** 2
    assert error < 1.5 * stated + 1e-4
    np.testing.assert_allclose(image.mean((0, 1)), reference.mean((0, 1)), rtol=0.006)
    np.testing.assert_allclose(answer.diagnostics.flux_in, beams.diagnostics.flux_in, rtol=1e-3)
    assert not (answer.status[0] == Status.INCOMPLETE).any()
