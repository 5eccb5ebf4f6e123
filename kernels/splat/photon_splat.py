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
from ..scene import Diagnostics, Spot, Sun
from ..solution import answer, check_texels
from ..status import Status
from .beams import splat
from .disc import Disc, within_disc
from .lander import Lander
from .landing import Plane, Rays
from .meetings import Meetings
from .photons import batches
from .plane import PlaneLander, one_plane
from .reflection import may_reflect_onto
from .sheet import Sheet
from .silhouettes import Silhouettes

_PILOT = 2.0  # photons a texel in each half of the first draw, which only tells how many are needed
_DECAY = 1.45  # measured: the error of stratified photons falls as n^-1.45, over still water and over folds alike
_MARGIN = 1.08
_DIRECTIONS = 32  # from which points of one half come, of a sun with a disc
_ROUNDING = 1e-12
_AGAIN = "second_meeting", "trapped"  # causes of loss where light meets the water again
# texels: how wide a thing may stand between rays unseen. On pool.blend 2 texels leave an error of 1e-5 and 1 of 4e-7.
_SIGHT, _THIN = (1.0, 2.0), 1e-3  # by the root of the tolerance over the second
_MOST = 1 << 26  # photons in a half
_REASONS = {False: "beams find every path, without noise, whatever the receiver", True: "points find every path"}
_LEFT_OUT = [
    "what lies between the rays: objects less than a texel wide as the light sees them count in part",
    "penumbrae of objects as wide as they are: they get the width of the water's own",
    "the size of lamps other than suns: light comes from their centre",
]

_BACKS = "a few per cent of the light next to normals whose back it meets, where what passes falls to nothing"


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
    outlines = Silhouettes(*solids)
    lights = [_Lit(scene, light, texels, tracer, outlines, solids, settings) for light in scene.lights]
    if not settings.points and any(lit.meets_backs() for lit in lights):
        work.left_out.append(_BACKS)
    work.seconds["prepare"] = time.perf_counter() - start
    start = time.perf_counter()
    if settings.points:
        irradiance = _until_good(lights, texels, settings, work).mean(0)
    else:
        irradiance = _by_beams(lights, texels, settings, work)
    work.seconds["photons"] = time.perf_counter() - start
    _tell_of_second_meetings(lights, settings.tolerance, work)
    return answer(scene, texels, irradiance, np.where(irradiance.any(1), Status.LIT, Status.DARK), work)


class _Lit:
    """One light, the water in it, and where that lands."""

    def __init__(self, scene, light, texels, tracer, outlines, solids, settings):
        self.scene, self.light, self.texels = scene, light, texels
        self._rest, self._tolerance = (tracer, outlines, solids, settings), settings.tolerance
        self.water, self._again = light_water(scene.water, light), 0
        shadowed = may_be_shadowed(self.water, *solids)
        meetings = Meetings.of(self.water, scene.water.twins, tracer, scene.eta)
        mirrors = may_reflect_onto(self.water, scene.receivers, meetings)
        never = meetings.never(self.water.source)
        source, medium = self.water.source, (scene.eta, np.asarray(scene.sigma_a, float))

        radius = light.angle / 2 if isinstance(light, Sun) else 0.0
        self.disc = Disc(self.water, scene.receivers, texels, scene.eta, radius, settings.tolerance)

        def lander(mirrored):
            again = None if never and not mirrored else meetings
            return Lander(scene.receivers, texels, tracer, outlines, again, source, *medium, mirrored)

        through = lander(mirrored=False)
        # The rim of a cone is a border, which needs rays; points know the plane for the sun in clear water only.
        plain = never and not (
            shadowed.any() or isinstance(light, Spot) or (settings.points and through.rows.total > 1)
        )
        plane = one_plane(scene, texels) if plain else None
        if plane is not None:
            through = PlaneLander(plane, texels[0].chart, source, *medium)
        self._rows, self._power = through.rows, source.power
        self._ways = [_Way(self.water, scene.water.twins, shadowed, through)]
        if mirrors.any():
            part = part_of(self.water, scene.water.twins, mirrors)
            self._ways.append(_Way(*part, shadowed[mirrors], lander(mirrored=True)))

    def meets_backs(self):
        """Whether light meets the back of any normal of a triangle that it lights."""
        water = self.water
        towards = self.water.source.incident(water.frame.T @ water.positions.T)[0]
        used = np.flatnonzero(water.area)
        facing = [
            (water.normals[water.normal_triangles[used, k]] @ water.frame).T
            * np.broadcast_to(towards, water.positions.T.shape)[:, water.triangles[used, k]]
            for k in range(3)
        ]
        return any((f.sum(0) <= 0).any() for f in facing)

    def spread(self):
        """Flux [W] per owned texel (K,3), per cause of loss and in all (3,), by beams, and its predicted relative mean
        squared error, which is to be within the tolerance."""
        side = self.texels[0].resolution
        sheet = Sheet(self._ways[-1].lander.image, len(self.texels), side, self._rows.count, self.disc.grain)
        texel_area = [t.area.sum() / len(t.area) for t in self.texels]
        count, area = sum(len(t.area) for t in self.texels), sum(t.area.sum() for t in self.texels)
        mean = min(self.water.light() / area, 1.0)  # if all light arrives, or as much as the source's power
        square = count * mean**2
        sight = float(np.clip(np.sqrt(self._tolerance / _THIN), *_SIGHT))
        work = [splat(*w.start(), sheet, texel_area, self._tolerance * square, sight) for w in self._ways]
        lost, met, errors = zip(*work, strict=True)
        flux = sheet.flux()
        beside = sheet.landed - flux.sum(1)
        lost[0]["missed"] += np.where(beside > _ROUNDING * sheet.landed, beside, 0.0)
        flux = np.stack([self.disc.blur(channel) for channel in flux])
        owned, *books = self._own(flux, lost, met)
        arrived = flux.sum() / sheet.channels / area
        error = sum(errors) / square * (mean / arrived) ** 2 if arrived > 0 else 0.0
        return owned, *books, error + self._doubt(owned)

    def _doubt(self, owned):
        """Relative mean squared error that the blur by the disc leaves in flux (K,3)."""
        if not (self.disc.seen and owned.any()):
            return 0.0
        mean = owned.sum(1) / np.concatenate([t.area for t in self.texels])
        return self.disc.error * mean.var() / mean.mean() ** 2

    def throw(self, photons, rng):
        """As `spread`, by about `photons` points, and how many there were."""
        if self.disc.seen:
            return self._throw_from_disc(photons, rng)
        flux, lost, met, used = 0.0, [], [], 0
        for way in self._ways:
            landing = way.points(self.scene, self.texels)
            for triangles, points, each in batches(way.water, photons * way.share(self.water), rng):
                landing.add(triangles, points, each)
                used += len(triangles) * points.shape[1]
            landed, own, all_of_it = landing.take()
            flux, lost, met = flux + landed, [*lost, own], [*met, all_of_it]
        return *self._own(flux, lost, met), used

    def _throw_from_disc(self, photons, rng):
        """As `throw`, from single directions within the sun's disc."""
        suns = within_disc(self.light, _DIRECTIONS, rng)
        flux, lost, met, used = 0.0, {}, 0.0, 0
        for sun in suns:
            part = _Lit(self.scene, sun, self.texels, *self._rest)
            own, causes, all_of_it, count = part.throw(photons / len(suns), rng)
            self._again += part.again()
            flux, met, used = flux + own / len(suns), met + all_of_it / len(suns), used + count
            lost = {cause: lost.get(cause, 0.0) + watts / len(suns) for cause, watts in causes.items()}
        return flux, lost, met, used

    def again(self):
        """How many rays met the water again."""
        return self._again + sum(way.lander.again for way in self._ways)

    def _own(self, flux, lost, met):
        """What the texels own of the images' flux (C, texels), what is lost, and what met the water; beside the charts
        it is missed.

        Light that is reflected is lost, by the first of `lost`, until the way that follows it has brought it home.
        """
        books = lost[0]
        for all_of_it, own in zip(met[1:], lost[1:]):
            again = {cause: own[cause] for cause in _AGAIN if cause in own}
            books["reflected"] = books["reflected"] - (all_of_it - sum(own.values()) + sum(again.values()))
            books |= {cause: books.get(cause, 0.0) + watts for cause, watts in again.items()}
        owned = []
        for k, channel in enumerate(flux):
            parts = [t.gather(part) for t, part in zip(self.texels, np.split(channel, len(self.texels)), strict=True)]
            books["missed"][k] += sum(off for _, off in parts)
            owned.append(np.concatenate([own for own, _ in parts]))
        coloured = {cause: self._in_colour(watts) for cause, watts in books.items()}
        return self._in_colour(np.stack(owned)).T, coloured, met[0] * self._power

    def _in_colour(self, flux):
        """Flux [W] (3, ...) in red, green and blue of flux (C, ...) [W for 1 W/m^2] of the channels."""
        return (flux[self._rows.channel].T * self._power).T


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


def _by_beams(lights, texels, settings, work):
    """Irradiance (K,3) by beams; books what comes in and what is lost."""
    area = np.concatenate([t.area for t in texels])
    flux = np.zeros((len(area), 3))
    errors = [0.0]
    for lit in lights:
        owned, lost, met, error = lit.spread()
        flux += owned
        errors.append(error)
        _book(work, lost, met)
    work.estimated_error = max(errors)
    work.paths = {"beams": sum(np.count_nonzero(lit.water.area) for lit in lights)}
    return flux / area[:, None]


def _tell_of_second_meetings(lights, tolerance, work):
    """Count rays that met the water again, and say so if more of their light than the tolerance was not followed."""
    again = sum(lit.again() for lit in lights)
    if again:
        work.paths["rays_that_meet_the_water_again"] = again
    weaker = sum(work.flux_lost.get(cause, np.zeros(3)).sum() for cause in _AGAIN)
    if weaker > tolerance * work.flux_in.sum():
        part = weaker / work.flux_in.sum()
        work.left_out.append(f"the weaker part of light that meets the water twice: {part:.1%} of all that comes in")


def _book(work, lost, met, share=1.0):
    """Add a `share` of {cause: (3,) W} lost and of what met the water (3,) to the books."""
    work.flux_in = work.flux_in + share * met
    for cause, watts in lost.items():
        work.flux_lost[cause] = work.flux_lost.get(cause, np.zeros(3)) + share * watts


def _until_good(lights, texels, settings, work):
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
            _book(work, lost, met, 1 / 2)
    return halves, used


def _difference(halves, area):
    """Mean squared error of the mean of two independent halves, over its squared mean, both weighted by area."""
    mean = (halves[0] + halves[1]).mean(1) / 2
    error = (halves[0] - halves[1]).mean(1) / 2
    total = (area * mean).sum() ** 2 / area.sum()
    return float((area * error**2).sum() / total) if total > 0 else 0.0
