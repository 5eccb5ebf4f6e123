"""The sun's disc under the walk: the same blur as under beams, and as many suns."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, floor, pool

from dapple.kernels.disc.disc import within_disc
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Settings, Sun
from dapple.kernels.splat import photon_splat
from dapple.kernels.walk import conic_walk

WIDE = np.radians(6.0)


def scene(angle):
    own = pool(lambda x, y: five_sines(x, y, 0.5), quads=32, receivers=[floor(side=3.0)])
    return replace(own, lights=(replace(own.lights[0], angle=angle),))


def bake(solve, own, tolerance=1e-3, **settings):
    return solve(own, [rasterise(r, 48) for r in own.receivers], Settings(tolerance=tolerance, **settings))


def relative(image, true):
    return ((image - true) ** 2).mean() / true.mean() ** 2


def test_means_take_the_disc_as_beams_do():
    """Both against the sum over many suns by beams: what the disc changes is right to a tenth, and the walk says by how
    much it is off."""
    own = scene(WIDE)
    suns = within_disc(own.lights[0], 80, np.random.default_rng(3))
    many = replace(own, lights=tuple(replace(sun, irradiance=sun.irradiance / len(suns)) for sun in suns))
    true = bake(photon_splat.solve, many).images[0]
    walked, beams = (bake(solve, own) for solve in (conic_walk.solve, photon_splat.solve))
    sharp = relative(bake(conic_walk.solve, scene(0.0)).images[0], true)
    off = relative(walked.images[0], true)
    assert off < sharp / 10
    assert off / 3 < walked.diagnostics.estimated_error < 10 * off
    assert relative(walked.images[0], beams.images[0]) < sharp / 10
    assert not any("disc" in sentence for sentence in walked.diagnostics.left_out)


def test_each_sun_has_its_own_disc():
    """Two suns, one of them without a disc: the map is the sum of theirs, and so are the books."""
    own = scene(WIDE)
    wide = own.lights[0]
    sharp = Sun("Sharp", np.array([0.0, 0.0, -1.0]), np.array([0.2, 0.5, 1.0]))
    both, one, other = (
        bake(conic_walk.solve, replace(own, lights=lights)) for lights in ((wide, sharp), (wide,), (sharp,))
    )
    np.testing.assert_allclose(both.images[0], one.images[0] + other.images[0], rtol=1e-9)
    received = [answer.diagnostics.flux_received["Floor"] for answer in (both, one, other)]
    np.testing.assert_allclose(received[0], received[1] + received[2], rtol=1e-9)
    assert both.diagnostics.paths["sub_points"] == sum(a.diagnostics.paths["sub_points"] for a in (one, other))


def test_the_blur_keeps_the_flux():
    blurred, sharp = (bake(conic_walk.solve, scene(angle)).diagnostics for angle in (WIDE, 0.0))
    assert blurred.flux_received["Floor"] == pytest.approx(sharp.flux_received["Floor"], rel=3e-3)


def test_the_first_root_says_that_it_leaves_the_disc_out():
    answer = bake(conic_walk.solve, scene(WIDE), first_root=True)
    assert any("disc" in sentence for sentence in answer.diagnostics.left_out)
