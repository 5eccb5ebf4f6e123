"""The estimate is honest: against the true waves, by references that share no code with the kernels."""

import numpy as np
import pytest

from dapple.kernels.anchor import Anchor, Kept
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings
from dapple.kernels.surface.smoothing import Smoothing
from dapple.tests.bench.estimate_ponds import by_chance, water_of
from dapple.tests.bench.reference_files import pond_by_waves

SIDE, CELLS = 80, 5.0  # texels of the map, and cells along a texel of the reference
SEEDS = 301, 302, 303, 304, 305, 306


@pytest.mark.parametrize("tolerance", [5e-2, 3e-3])
def test_within_a_factor_of_2_of_the_truth_and_under_the_tolerance(tolerance):
    """Of six ponds from still to stormy, by chance; one may be off by a factor of 3."""
    ratios = []
    for seed in SEEDS:
        pond, quads, _ = by_chance(seed)
        scene = pond.scene(water_of(pond, quads))
        sharp = tuple(type(light)(light.name, light.direction, light.irradiance) for light in scene.lights)
        scene = type(scene)(scene.water, scene.receivers, (), sharp, scene.eta)
        own = [rasterise(scene.receivers[0], SIDE)]
        answer = solve(scene, own, Settings(tolerance=tolerance), Kept(Anchor(Smoothing(0.002, 1.0))))
        cells = round(pond.side / pond.floor.side * SIDE * CELLS)
        true = pond_by_waves(pond, pond.direction, SIDE, cells)
        error = ((answer.images[0][..., 0] - true) ** 2).mean() / (true**2).mean()
        assert error <= tolerance, seed
        ratios.append(error / answer.diagnostics.estimated_error)
    off = np.exp(np.abs(np.log(ratios)))
    assert (off <= 2).sum() >= len(SEEDS) - 1 and off.max() <= 3, ratios
