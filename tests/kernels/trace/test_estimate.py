"""The estimated error of light over casters, against many points, where beams meet in a focus."""

import numpy as np
from casters import ball, no_water
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Scene, Settings
from dapple.kernels.trace.cast import over_casters


def test_the_estimate_at_a_focus_knows_that_errors_add_up():
    """A ball whose light meets on the floor: nearly all of the error is in a few texels, in which hundreds of beams
    err to the same side, and out of one texel over all of its borders. Without what they leave together it is 25 times
    too low."""
    scene = Scene(no_water(), (floor(side=3.0),), (), (sun((0.1, 0.05, -1)),), casters=(ball(0.5, (0, 0, 0.75)),))
    texels = [rasterise(receiver, 128) for receiver in scene.receivers]
    (cast,) = over_casters(scene, texels, Settings(resolution=128, tolerance=0.01))
    flux, _, _, error = cast.spread()
    area, light = texels[0].area, flux[:, 0] / texels[0].area
    halves = [cast.throw(3e5, np.random.default_rng(seed))[0][:, 0] / area for seed in (1, 2)]
    wrong = (area * (light - halves[0]) * (light - halves[1])).sum()  # without the noise of the points
    wrong *= area.sum() / (area * light).sum() ** 2
    assert 1 / 2 < error / wrong < 3 and wrong > 1e-3
