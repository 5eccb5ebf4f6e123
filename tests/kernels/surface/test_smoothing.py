"""How much is smoothed: little where the vertices lie on the water, more the noisier they are."""

import numpy as np
import pytest
from waves import five_sines

from dapple.kernels.surface.fit import fit
from dapple.kernels.surface.smoothing import LADDER, Smoothing, _last_that_pays


def vertices(noise, count=1600, side=2.0, seed=0, shape=five_sines):
    """Points in the cells of a grid, on the waves but for noise [m], their slopes, and their distance."""
    rng = np.random.default_rng(seed)
    n = round(np.sqrt(count))
    i = np.arange(n * n)
    x, y = (np.stack([i % n, i // n]) + rng.uniform(0.2, 0.8, (2, n * n))) * (side / n) - side / 2
    z, *slopes = shape(x, y)
    return np.stack([x, y, z + noise * rng.standard_normal(n * n)], 1), np.array(slopes), side / n


def slope_error(points, distance, smoothing):
    x, y = points[:, 0], points[:, 1]
    inner = np.maximum(np.abs(x), np.abs(y)) < 0.85
    _, *found = fit(points, distance, smoothing).at(x, y)
    return np.sqrt(((np.array(found) - five_sines(x, y)[1:])[:, inner] ** 2).sum(0).mean())


@pytest.mark.parametrize("noise", [0.0, 5e-5, 2e-4, 1e-3])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_choice_is_near_the_best_on_the_ladder(noise, seed):
    points, slopes, distance = vertices(noise, seed=seed)
    chosen = Smoothing().settled(points, slopes, distance).value
    errors = {smoothing: slope_error(points, distance, smoothing) for smoothing in LADDER}
    assert errors[chosen] < 1.5 * min(errors.values())


def test_noise_raises_it():
    chosen = [Smoothing().settled(*vertices(noise)).value for noise in (0.0, 5e-5, 2e-4, 1e-3)]
    assert chosen == sorted(chosen) and chosen[0] <= 6e-3 and chosen[-1] >= 0.06


def test_the_window_is_where_the_waves_are():
    """Waves on a twentieth of still water decide, not the still rest."""

    def ripple(x, y):
        here = np.exp(-((x - 0.6) ** 2 + (y + 0.5) ** 2) / 0.02)
        return tuple(here * part for part in five_sines(x, y))

    points, slopes, distance = vertices(0.0, count=10000, shape=ripple)
    assert Smoothing().settled(points, slopes, distance).value <= 6e-3


def test_a_chequered_error_is_not_taken_for_waves():
    """Vertices of an interpolated iso-surface: half of them a little low, by their place in the cells."""
    points, slopes, distance = vertices(0.0)
    low = (np.floor(points[:, 0] / distance) + np.floor(points[:, 1] / distance)) % 2 == 0
    points[low, 2] -= 3e-4
    chosen = Smoothing().settled(points, slopes, distance).value
    assert slope_error(points, distance, chosen) < 0.6 * slope_error(points, distance, LADDER[-1])


def test_it_stays_over_a_sequence_but_not_from_still_water_on():
    noisy, clean = vertices(2e-4), vertices(0.0)
    first = Smoothing().settled(*noisy)
    assert first.value > 6e-3 and first.settled(*clean) is first

    def still(x, y):
        return tuple(1e-7 * part for part in five_sines(x, y))

    calm = Smoothing().settled(*vertices(1e-7, shape=still))
    own = calm.settled(*clean)
    assert own == Smoothing().settled(*clean) and own.value < first.value


@pytest.mark.parametrize(
    ("errors", "rung"),
    [
        ([4, 3, 2, 1, 0.5, 0.4], 5),  # waves
        ([2, 1, 1.1, 1.2, 1.3, 1.4], 1),  # noise
        ([2, 1, 0.98, 0.96, 0.9, 0.8], 1),  # an iso-surface's pattern
        ([2, 1.96, 1.9, 1.8, 1.5, 1.2], 5),  # folds that only the last rungs resolve
        ([0, 0, 0, 0, 0, 0], 0),  # still water
    ],
)
def test_the_rung_to_stop_at(errors, rung):
    assert _last_that_pays(errors) == rung
