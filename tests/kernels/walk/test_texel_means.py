"""Means over texels: against beams, which know nothing of paths, with folds, borders, shadows and absorption."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, flat, floor, grid, pool, quad

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Occluder, Receiver, Scene, Settings
from dapple.kernels.splat.photon_splat import solve
from dapple.kernels.status import Status
from dapple.kernels.walk.conic_walk import solve as walk


def by_walk(scene, texels, tolerance, seed=0):
    return walk(scene, texels, Settings(method="conic_walk", tolerance=tolerance, seed=seed))


def by_beams(scene, texels):
    return solve(scene, texels, Settings(method="photon_splat", tolerance=1e-6)).images


def error(image, reference):
    """Relative mean squared error of the first channel."""
    return ((image - reference)[..., 0] ** 2).mean() / reference[..., 0].mean() ** 2


def stormy(receivers, quads=64):
    return pool(lambda x, y: five_sines(x, y, 2.0), quads=quads, receivers=receivers, side=6.0)


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.002])
def test_storms_agree_with_exact_coverage_within_the_estimate(tolerance):
    """Folds cross most texels; the measured error is the one that the method states, and no light is lost."""
    scene = stormy([floor()])
    texels = [rasterise(scene.receivers[0], 64)]
    answer = by_walk(scene, texels, tolerance)
    reference = by_beams(scene, texels)[0]
    stated = answer.diagnostics.estimated_error
    assert stated <= tolerance
    assert 0.6 * stated < error(answer.images[0], reference) < 1.5 * stated
    assert answer.images[0].mean() == pytest.approx(reference.mean(), rel=4 * np.sqrt(stated) / 64)
    assert answer.diagnostics.texels == {"lit": 64 * 64}


def test_the_mean_of_many_draws_is_the_exact_mean():
    """No bias in any texel: sixteen coarse draws scatter round exact coverage as their own spread says."""
    scene = stormy([floor()])
    texels = [rasterise(scene.receivers[0], 24)]
    draws = np.array([by_walk(scene, texels, 1.0, seed).images[0][..., 0] for seed in range(16)])
    reference = by_beams(scene, texels)[0][..., 0]
    off, spread = ((draws.mean(0) - reference) ** 2).mean(), draws.var(0, ddof=1).mean() / 16
    assert 0.75 < off / spread < 1.33
    means = draws.mean((1, 2))
    assert abs(means.mean() - reference.mean()) < 4 * means.std(ddof=1) / 4


def test_a_focus_in_one_texel_is_finite_and_right():
    """A crest's focus on the floor: infinite light at a point, and all of the crest's light in its texel."""
    radius, eta = 1.0, 1.333

    def crest(x, y):
        sphere = np.sqrt(radius**2 - x**2 - y**2)
        return sphere - radius, -x / sphere, -y / sphere

    focus = floor(side=0.21, z=1.5 - radius * eta / (eta - 1))
    scene = pool(crest, quads=33, direction=(0, 0, -1), side=0.2, receivers=[focus], eta=eta)
    answer = by_walk(scene, [rasterise(focus, 21)], 1e-3)
    image = answer.images[0][..., 0]
    assert np.isfinite(image).all()
    passed = 1 - ((eta - 1) / (eta + 1)) ** 2
    assert image[10, 10] * 1e-4 == pytest.approx(0.04 * passed, rel=0.01)
    assert image.sum() * 1e-4 == pytest.approx(0.04 * passed, rel=2e-3)


def test_partly_covered_texels_hold_the_mean_over_what_is_covered():
    """Flat water: every texel of a chart that cuts texels in any way holds the same irradiance."""
    island = quad("Island", [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], (0.13, 0.21), (0.77, 0.68))
    scene = pool(flat, quads=24, side=12.0, receivers=[island])
    texels = [rasterise(island, 40)]
    image = by_walk(scene, texels, 1e-4).images[0].reshape(-1, 3)[texels[0].texel]
    np.testing.assert_allclose(image, np.broadcast_to(image[0], image.shape), rtol=1e-6)


def several_receivers():
    x, y, triangles = grid(12, 2.0)
    uv = np.stack([(x + 1) / 2, (y + 1) / 2], 1) * 0.9 + 0.05
    hills = Receiver("Hills", np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)], 1), triangles, uv[triangles])
    wall = quad("Wall", [[1.1, -1, 0], [1.1, 1, 0], [1.1, 1, 1.2], [1.1, -1, 1.2]])
    return [hills, wall]


def test_hills_walls_and_shadows_agree_with_exact_coverage():
    raft = floor(side=0.7, z=0.8)
    scene = replace(stormy(several_receivers()), occluders=(Occluder("Raft", raft.positions, raft.triangles),))
    texels = [rasterise(r, 32) for r in scene.receivers]
    answer = by_walk(scene, texels, 0.003)
    assert answer.diagnostics.paths["blocked"] > 0
    squares = power = 0
    for own, image, reference in zip(texels, answer.images, by_beams(scene, texels), strict=True):
        image, reference = (v.reshape(-1, 3)[own.texel, 0] for v in (image, reference))
        squares += own.area @ (image - reference) ** 2
        power += own.area @ reference
        assert own.area @ image == pytest.approx(own.area @ reference, rel=0.01)
    total = sum(own.area.sum() for own in texels)
    # Of beams against points, which are independent of both, the error is 3e-4 here.
    assert squares / total / (power / total) ** 2 < 1.5 * answer.diagnostics.estimated_error + 6e-4


def test_absorption_follows_the_true_path():
    """Flat water absorbs exp(-sigma d / cos_t), channel by channel."""
    plain = pool(flat, quads=24, direction=(0.5, 0, -np.sqrt(0.75)), side=12.0)
    murky = Scene(**{**vars(plain), "sigma_a": np.array([0.4, 0.1, 0.0])})
    texels = [rasterise(plain.receivers[0], 8)]
    clear, dim = (by_walk(s, texels, 0.01).images[0] for s in (plain, murky))
    cos_t = np.sqrt(1 - 0.25 / 1.333**2)
    np.testing.assert_allclose(dim, clear * np.exp(-np.array([0.4, 0.1, 0.0]) * 1.5 / cos_t), rtol=1e-9)


def test_a_smaller_tolerance_takes_more_points_and_a_frame_repeats_itself():
    scene = stormy([floor()])
    texels = [rasterise(scene.receivers[0], 32)]
    coarse, fine, again = (by_walk(scene, texels, t) for t in (0.1, 0.001, 0.001))
    assert fine.diagnostics.paths["sub_points"] > coarse.diagnostics.paths["sub_points"]
    np.testing.assert_array_equal(fine.images[0], again.images[0])
    assert (fine.status[0] == Status.LIT).all()
