"""Photon splatting: the forward estimator. Complete - every path that the water bends - and it keeps the energy.

Photons start stratified on the water, are refracted once and land on the first surface below; a texel's irradiance is
the flux that landed in it over its area. Half of them are drawn apart from the other half, and the difference of the
two pictures is the estimate of the error. After [1] caustics volumes (De Barro et al.), [2] caustics mapping (Shah et
al. 2007) and [3] collection points (Moreau & Doggett 2022), with stratification in place of their random photons.
"""

from __future__ import annotations

import time

import numpy as np

from .landing import Plane, Rays
from .lit_water import light_water, may_be_shadowed
from .photons import batches
from .rays import Tracer, soup
from .scene import Diagnostics
from .solution import answer, check_texels
from .status import Status

_PILOT = 2.0  # photons a texel in each half of the first draw, which only tells how many are needed
_DECAY = 1.45  # measured: the error of stratified photons falls as n^-1.45, over still water and over folds alike
_MARGIN = 1.08
_MOST = 1 << 26  # photons in a half
_LEFT_OUT = [
    "the sun's disc: light comes from its centre",
    "light that meets the water twice, is reflected by it or is absorbed in it",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by photons; see `scene.Solution`.

    Settings.tolerance is the relative mean squared error at which it stops adding photons. Raises ValueError where
    texels and receivers do not match.
    """
    check_texels(scene, texels)
    work = Diagnostics("photon_splat", "photons find every path, whatever the receiver")
    start = time.perf_counter()
    tracer = Tracer(*soup((*scene.receivers, *scene.occluders)))
    suns = [_Lit(scene, sun, texels, tracer) for sun in scene.suns]
    work.seconds["prepare"] = time.perf_counter() - start
    start = time.perf_counter()
    halves = _until_good(suns, texels, settings, work)
    work.seconds["photons"] = time.perf_counter() - start
    work.left_out = list(_LEFT_OUT)
    irradiance = halves.mean(0)
    return answer(scene, texels, irradiance, np.where(irradiance.any(1), Status.LIT, Status.DARK), work)


class _Lit:
    """One sun's water and where its photons land."""

    def __init__(self, scene, sun, texels, tracer):
        self.sun, self.lit = sun, light_water(scene.water, sun)
        shadowed = may_be_shadowed(self.lit, *soup((*scene.receivers, *scene.occluders)))
        plane = Plane.of(scene, texels, self.lit) if not shadowed.any() else None
        self.landing = plane or Rays(scene, texels, self.lit, shadowed, tracer)

    def splat(self, photons, rng):
        """Flux [W for 1 W/m^2] per texel of all receivers (K,), per cause of loss {cause: W}, and photons used."""
        used = 0
        for triangles, points, flux in batches(self.lit, photons, rng):
            self.landing.add(triangles, points, flux)
            used += len(triangles) * points.shape[1]
        return *self.landing.take(), used


def _until_good(suns, texels, settings, work):
    """Irradiance (2, K, 3) of two independent halves, with photons added until their difference is within tolerance."""
    area = np.concatenate([t.area for t in texels])
    water = max((s.lit.area.sum() for s in suns), default=0.0)
    photons = min(_PILOT * water * len(area) / area.sum(), _MOST)
    while True:
        halves, used = _halves(suns, photons, len(area), settings.seed, work)
        halves /= area[:, None]
        work.paths = {"photons": used}
        error = work.estimated_error = _difference(halves, area)
        if error <= settings.tolerance or photons >= _MOST or not used:
            return halves
        drawn = used / (2 * len(suns))  # a little more than asked for: strata are whole
        photons = min(drawn * _MARGIN * (error / settings.tolerance) ** (1 / _DECAY), _MOST)


def _halves(suns, photons, count, seed, work):
    """Flux (2, K, 3) [W] on the texels of two independent draws; books losses and incoming flux in `work`."""
    halves = np.zeros((2, count, 3))
    used = 0
    work.flux_in, work.flux_lost = np.zeros(3), {}
    for lit in suns:
        work.flux_in += lit.lit.area.sum() * lit.sun.irradiance
        for half in (0, 1):
            flux, lost, n = lit.splat(photons, np.random.default_rng([seed, half]))
            halves[half] += flux[:, None] * lit.sun.irradiance
            used += n
            for cause, watts in lost.items():
                work.flux_lost[cause] = work.flux_lost.get(cause, np.zeros(3)) + watts / 2 * lit.sun.irradiance
    return halves, used


def _difference(halves, area):
    """Mean squared error of the mean of two independent halves, over its squared mean, both weighted by area."""
    mean = (halves[0] + halves[1]).mean(1) / 2
    error = (halves[0] - halves[1]).mean(1) / 2
    total = (area * mean).sum() ** 2 / area.sum()
    return float((area * error**2).sum() / total) if total > 0 else 0.0
