"""Points in two halves, drawn apart: their difference is the estimate of the error, and tells how many are needed."""

from __future__ import annotations

import numpy as np

from ..solution import book

_PILOT = 2.0  # photons a texel in each half of the first draw, which only tells how many are needed
_DECAY = 1.45  # measured: the error of stratified photons falls as n^-1.45, over still water and over folds alike
_MARGIN = 1.08
_MOST = 1 << 26  # photons in a half


def until_good(lights, texels, settings, work):
    """Irradiance (2, K, 3) of two independent halves, with photons added until their difference is within tolerance."""
    area = np.concatenate([t.area for t in texels])
    water = max((s.water.area.sum() for s in lights), default=0.0)
    photons = min(_PILOT * water * len(area) / area.sum(), _MOST)
    while True:
        halves, used = _halves(lights, photons, len(area), settings.seed, work)
        halves /= area[:, None]
        work.paths = {"photons": used}
        error = work.estimated_error = _difference(halves, area)
        if error <= settings.tolerance or photons >= _MOST or not used:
            return halves
        drawn = used / (2 * len(lights))  # a little more than asked for: strata are whole
        photons = min(drawn * _MARGIN * (error / settings.tolerance) ** (1 / _DECAY), _MOST)


def _halves(lights, photons, count, seed, work):
    """Flux (2, K, 3) [W] on the texels of two independent draws, and photons used; books losses in `work`."""
    halves = np.zeros((2, count, 3))
    used = 0
    work.flux_lost, work.flux_in = {}, np.zeros(3)
    for lit in lights:
        for half in (0, 1):
            flux, lost, met, n = lit.throw(photons, np.random.default_rng([seed, half]))
            halves[half] += flux
            used += n
            book(work, lost, met, 1 / 2)
    return halves, used


def _difference(halves, area):
    """Mean squared error of the mean of two independent halves, over its squared mean, both weighted by area."""
    mean = (halves[0] + halves[1]).mean(1) / 2
    error = (halves[0] - halves[1]).mean(1) / 2
    total = (area * mean).sum() ** 2 / area.sum()
    return float((area * error**2).sum() / total) if total > 0 else 0.0
