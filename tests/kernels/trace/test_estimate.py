"""The estimated error of light over casters, against many points: honest where beams meet in a focus."""

import numpy as np
from casters import ball, no_water
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Scene, Settings
from dapple.kernels.trace.cast import over_casters


def test_the_estimate_at_a_focus_is_near_the_error():
    """A ball whose light meets on the floor: nearly all of the error is in a few texels, in which hundreds of beams
    err to the same side."""
    scene = Scene(no_water(), (floor(side=3.0),), (), (sun((0.1, 0.05, -1)),), casters=(ball(0.5, (0, 0, 0.75)),))
    texels = [rasterise(receiver, 64) for receiver in scene.receivers]
    (cast,) = over_casters(scene, texels, Settings(resolution=64, tolerance=0.03))
    flux, _, _, error = cast.spread()
    truth, *_ = cast.throw(1e6, np.random.default_rng(1))
    area = texels[0].area
    light, expected = flux[:, 0] / area, truth[:, 0] / area
    wrong = (area * (light - expected) ** 2).sum() * area.sum() / (area * expected).sum() ** 2
    assert 1 / 3 < error / wrong < 3 and wrong > 1e-3
