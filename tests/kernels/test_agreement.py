"""Two estimators of one integral: where one path leads to every point, walk and photons must agree texel by texel."""

import numpy as np
from casters import ball
from waves import calm, floor, grid, pool

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Receiver, Settings

REPLICAS = 16
SUB = 24


def test_walk_and_photons_agree_texel_by_texel():
    """On one mesh, photons give means of texels with independent errors over seeds; the walk, averaged over 24 x 24
    points a texel, gives the same mean almost without error. The standardised differences follow Student's t."""
    scene = pool(calm, quads=64, receivers=[floor(side=2.0)])
    side = 16
    coarse, fine = [rasterise(scene.receivers[0], side)], [rasterise(scene.receivers[0], side * SUB)]
    walk = solve(scene, fine, Settings(method="conic_walk", surface="mesh"))
    assert walk.diagnostics.texels == {"lit": (side * SUB) ** 2}
    walked = walk.images[0][..., 0].reshape(side, SUB, side, SUB).mean((1, 3))
    drawn = [
        Settings(method="photon_splat", tolerance=1e-3, points=True, seed=seed, surface="mesh")
        for seed in range(REPLICAS)
    ]
    photons = [solve(scene, coarse, settings).images[0][..., 0] for settings in drawn]
    mean, error = np.mean(photons, axis=0), np.std(photons, axis=0, ddof=1) / np.sqrt(REPLICAS)
    z = (mean - walked) / error
    # 256 texels, t with 15 degrees of freedom: deviation sqrt(15 / 13) = 1.07, and a mean within 4 standard errors.
    assert abs(z.mean()) < 4 * 1.07 / np.sqrt(z.size)
    assert 0.9 < z.std() < 1.3
    assert np.abs(z).max() < 6.5
    assert np.ptp(walked) > 0.2, "the waves must focus, or the test shows nothing"


def test_walk_and_beams_agree_over_an_uneven_bed_under_a_fish():
    """Waves that fold their light over a relief, with something opaque in the water: the two differ by no more than the
    walk says of itself, and agree on the shadow."""
    x, y, triangles = grid(40, 3.0)
    relief = 0.2 * np.sin(1.9 * x + 0.4) * np.cos(1.5 * y) + 0.05 * np.sin(4 * x - 2 * y)
    bed = Receiver("Bed", np.stack([x, y, relief], 1), triangles, (np.stack([x, y], 1) / 3 + 0.5)[triangles])
    body = ball(fine=12)
    fish = Occluder("Fish", body.positions * [0.3, 0.1, 0.1] + [0.2, -0.1, 0.7], body.triangles)
    scene = pool(receivers=[bed], occluders=[fish])
    texels = [rasterise(bed, 48)]
    beams, walk = (solve(scene, texels, Settings(m, 1e-3, surface="mesh")) for m in ("photon_splat", "conic_walk"))
    spread, walked = (answer.images[0][..., 0] for answer in (beams, walk))
    mean = spread.mean()
    own = walk.diagnostics.estimated_error + beams.diagnostics.estimated_error
    assert 0 < own < 1.1e-3
    assert ((walked - spread) ** 2).mean() / mean**2 < 2 * own
    np.testing.assert_allclose(walked.mean(), mean, rtol=2e-3)
    shadow = spread < 0.05 * mean
    assert shadow.sum() > 8 and (shadow != (walked < 0.05 * mean)).sum() <= 2
    assert spread.max() > 3 * mean, "the waves must fold, or the test shows nothing"


def test_both_answer_in_one_form():
    scene = pool(calm, quads=16)
    texels = [rasterise(scene.receivers[0], 16)]
    for method in ("conic_walk", "photon_splat"):
        answer = solve(scene, texels, Settings(method=method))
        d = answer.diagnostics
        assert d.method == method and d.reason and d.left_out
        assert answer.images[0].shape == (16, 16, 3) and answer.status[0].shape == (16, 16)
        assert set(d.flux_received) == {"Floor"} and d.flux_in.shape == (3,)
        assert sum(d.texels.values()) == 256
        np.testing.assert_allclose(sum(d.flux_received.values()) + sum(d.flux_lost.values()), d.flux_in, rtol=1e-6)
