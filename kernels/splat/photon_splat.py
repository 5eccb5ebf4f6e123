"""Photon splatting: the forward estimator. Complete - every path that the water bends - and it keeps the energy.

By default a photon is a beam, a triangle of the water with its true footprint (`beams.py`): no noise. As points, the
photons start stratified on the water, are refracted once and land on the first surface below; half of them are drawn
apart from the other half, and the difference of the two pictures is the estimate of the error. Points are the
independent check of the beams. After [1] caustics volumes (De Barro et al.), [2] caustics mapping (Shah et al. 2007)
and [3] collection points (Moreau & Doggett 2022), with footprints and strata in place of their random photons.
"""

from __future__ import annotations

import time

import numpy as np

from ..lit_water import light_water, may_be_shadowed, part_of
from ..rays import Tracer, soup
from ..scene import Diagnostics, Sun
from ..solution import answer, check_texels
from ..status import Status
from .beams import splat
from .lander import Lander
from .landing import Plane, Rays
from .photons import batches
from .plane import PlaneLander, one_plane
from .reflection import may_reflect_onto
from .sheet import Sheet

_PILOT = 2.0  # photons a texel in each half of the first draw, which only tells how many are needed
_DECAY = 1.45  # measured: the error of stratified photons falls as n^-1.45, over still water and over folds alike
_MARGIN = 1.08
_ROUNDING = 1e-12
_MOST = 1 << 26  # photons in a half
_REASONS = {False: "beams find every path, without noise, whatever the receiver", True: "points find every path"}
_LEFT_OUT = [
    "what lies between the rays: objects less than about six texels wide as the light sees them count in part",
    "the sun's disc: light comes from its centre",
    "light that meets the water twice or is absorbed in it",
]


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by photons; see `scene.Solution`.

    Settings.tolerance is the relative mean squared error that is good enough, against the same mesh; Settings.points
    asks for points. Raises ValueError where texels and receivers do not match.
    """
    check_texels(scene, texels)
    work = Diagnostics("photon_splat", _REASONS[settings.points], left_out=list(_LEFT_OUT))
    start = time.perf_counter()
    solids = soup((*scene.receivers, *scene.occluders))
    tracer = Tracer(*solids)
    suns = [_Lit(scene, sun, texels, tracer, solids) for sun in scene.lights if isinstance(sun, Sun)]
    work.left_out += [f"lamp '{light.name}'" for light in scene.lights if not isinstance(light, Sun)]
    work.flux_in = sum((lit.water.area.sum() * lit.sun.irradiance for lit in suns), np.zeros(3))
    work.seconds["prepare"] = time.perf_counter() - start
    start = time.perf_counter()
    if settings.points:
        irradiance = _until_good(suns, texels, settings, work).mean(0)
    else:
        irradiance = _by_beams(suns, texels, settings, work)
    work.seconds["photons"] = time.perf_counter() - start
    return answer(scene, texels, irradiance, np.where(irradiance.any(1), Status.LIT, Status.DARK), work)


class _Lit:
    """One sun, the water in its light, and where that lands."""

    def __init__(self, scene, sun, texels, tracer, solids):
        self.scene, self.sun, self.texels = scene, sun, texels
        self.water = light_water(scene.water, sun)
        shadowed = may_be_shadowed(self.water, *solids)
        mirrors = may_reflect_onto(self.water, scene.receivers)
        plane = None if shadowed.any() else one_plane(scene, texels)

        def lander(mirrored):
            return Lander(scene.receivers, texels, tracer, self.water.frame[2], scene.eta, mirrored)

        if plane is None:
            through = lander(mirrored=False)
        else:
            through = PlaneLander(plane, texels[0].chart, self.water.frame[2], scene.eta)
        self._ways = [_Way(self.water, scene.water.twins, shadowed, through)]
        if mirrors.any():
            part = part_of(self.water, scene.water.twins, mirrors)
            self._ways.append(_Way(*part, shadowed[mirrors], lander(mirrored=True)))

    def spread(self, tolerance):
        """Flux [W for 1 W/m^2] per owned texel (K,) and per cause of loss, by beams, and its predicted relative mean
        squared error, which is to be within the tolerance."""
        sheet = Sheet(self._ways[0].lander.image, len(self.texels), self.texels[0].resolution)
        texel_area = [t.area.sum() / len(t.area) for t in self.texels]
        count, area = sum(len(t.area) for t in self.texels), sum(t.area.sum() for t in self.texels)
        mean = min(self.water.area.sum() / area, 1.0)  # if all light arrives, or as much as a sun brings
        square = count * mean**2
        lost, errors = zip(*(splat(*w.start(), sheet, texel_area, tolerance * square) for w in self._ways), strict=True)
        flux = sheet.flux()
        beside = sheet.landed - flux.sum(1)
        lost[0]["missed"] += np.where(beside > _ROUNDING * sheet.landed, beside, 0.0)
        mean = flux.sum() / sheet.channels / area
        return *self._own(flux[0], lost), sum(errors) / (count * mean**2) if mean > 0 else 0.0

    def throw(self, photons, rng):
        """As `spread`, by about `photons` points, and how many there were."""
        flux, lost, used = 0.0, [], 0
        for way in self._ways:
            landing = way.points(self.scene, self.texels)
            for triangles, points, each in batches(way.water, photons * way.share(self.water), rng):
                landing.add(triangles, points, each)
                used += len(triangles) * points.shape[1]
            landed, own = landing.take()
            flux, lost = flux + landed, [*lost, own]
        return *self._own(flux, lost), used

    def _own(self, flux, lost):
        """What the texels own of the images' flux; what fell beside the charts is missed.

        Light that is reflected is lost, by the first of `lost`, until the way that follows it has brought it home.
        """
        books = lost[0]
        for way, own in zip(self._ways[1:], lost[1:]):
            books["reflected"] -= way.water.area.sum() - sum(own.values())
        parts = [t.gather(part) for t, part in zip(self.texels, np.split(flux, len(self.texels)), strict=True)]
        books["missed"] += sum(off for _, off in parts)
        return np.concatenate([owned for owned, _ in parts]), books


class _Way:
    """A way that light takes from the water, through it or off it: from which LitWater, with its twins, where it may
    lie in a shadow (T,), and the Lander that follows it."""

    def __init__(self, water, twins, shadowed, lander):
        self.water, self.twins, self.shadowed, self.lander = water, twins, shadowed, lander
        self._points = None

    def start(self):
        """What `splat` takes of it."""
        return self.water, self.twins, self.lander, self.shadowed

    def share(self, water):
        """Share of the light on `water` that starts this way."""
        total = water.area.sum()
        return self.water.area.sum() / total if total else 0.0

    def points(self, scene, texels):
        """What lands points that go this way."""
        if self._points is None:
            if self.lander.certain:
                self._points = Plane(texels[0], scene.eta, self.water, self.lander.plane)
            else:
                self._points = Rays(self.lander, len(texels), texels[0].resolution, self.water, self.shadowed)
        return self._points


def _by_beams(suns, texels, settings, work):
    """Irradiance (K,3) by beams; books losses."""
    area = np.concatenate([t.area for t in texels])
    irradiance = np.zeros((len(area), 3))
    errors = [0.0]
    for lit in suns:
        owned, lost, error = lit.spread(settings.tolerance)
        irradiance += (owned / area)[:, None] * lit.sun.irradiance
        errors.append(error)
        _book(work, lost, lit.sun)
    work.estimated_error = max(errors)
    work.paths = {"beams": sum(np.count_nonzero(lit.water.area) for lit in suns)}
    return irradiance


def _book(work, lost, sun):
    """Add {cause: W for 1 W/m^2} of one sun to the books."""
    for cause, watts in lost.items():
        work.flux_lost[cause] = work.flux_lost.get(cause, np.zeros(3)) + watts * sun.irradiance


def _until_good(suns, texels, settings, work):
    """Irradiance (2, K, 3) of two independent halves, with photons added until their difference is within tolerance."""
    area = np.concatenate([t.area for t in texels])
    water = max((s.water.area.sum() for s in suns), default=0.0)
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
    """Flux (2, K, 3) [W] on the texels of two independent draws, and photons used; books losses in `work`."""
    halves = np.zeros((2, count, 3))
    used = 0
    work.flux_lost = {}
    for lit in suns:
        for half in (0, 1):
            flux, lost, n = lit.throw(photons, np.random.default_rng([seed, half]))
            halves[half] += flux[:, None] * lit.sun.irradiance
            used += n
            _book(work, {cause: watts / 2 for cause, watts in lost.items()}, lit.sun)
    return halves, used


def _difference(halves, area):
    """Mean squared error of the mean of two independent halves, over its squared mean, both weighted by area."""
    mean = (halves[0] + halves[1]).mean(1) / 2
    error = (halves[0] - halves[1]).mean(1) / 2
    total = (area * mean).sum() ** 2 / area.sum()
    return float((area * error**2).sum() / total) if total > 0 else 0.0
