"""One light and the ways that it takes from the water: through it and off it, by beams or by points, and the books."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..area_lamps import among
from ..disc.disc import Disc, within_disc
from ..lit_water import may_be_shadowed, part_of
from ..maps.texels import gather_all
from ..scene import Spot
from .beams import splat
from .edges import Edges
from .lander import BACK, LOST, Lander
from .landing import Plane, Rays
from .photons import batches
from .plane import PlaneLander
from .reflection import may_reflect_onto
from .sheet import Sheet

AGAIN = "second_meeting", "trapped"  # causes of loss where light meets the water again
_NAMED = (*AGAIN, LOST[BACK])  # that light which the water reflects is lost by, under a name of its own
_DIRECTIONS = 32  # from which points of one half come, of a sun with a disc
_ROUNDING = 1e-12
# texels: how wide a thing may stand between rays unseen. On pool.blend 2 texels leave an error of 1e-5 and 1 of 4e-7.
_SIGHT, _THIN = (1.0, 2.0), 5e-4  # by the root of the tolerance over the second


class Lit:
    """One light, the water in it, and where that lands."""

    def __init__(self, light, around):
        # Errors of pieces are not all alike, nor all apart.
        self.light, self._around, self._tolerance = light, around, around.settings.tolerance * among(light) ** 0.5
        self.scene, self.texels = scene, texels = around.scene, around.texels
        self.water, self._again = around.lit(light), 0
        without = around.settings.without
        fresnel, count = "fresnel" not in without, len(self.water.area)
        # Light that all passes leaves none to be reflected.
        reflects, again = fresnel and "reflection" not in without, "second_crossing" not in without
        shadowed = np.zeros(count, bool) if "occlusion" in without else may_be_shadowed(self.water, *around.solids)
        meetings = around.meetings(self.water) if reflects or again else None
        mirrors = may_reflect_onto(self.water, scene.receivers, meetings) if reflects else np.zeros(count, bool)
        never = not again or meetings.never(self.water.source)
        source, medium = self.water.source, (scene.eta, np.asarray(scene.sigma_a, float))

        self.disc = Disc(self.water, scene.receivers, texels, scene.eta, light, self._tolerance)

        def lander(mirrored):
            met = None if never and not mirrored else meetings
            surroundings = around.tracer, around.outlines, met
            return Lander(scene.receivers, texels, *surroundings, source, *medium, mirrored, fresnel)

        through = lander(mirrored=False)
        # The rim of a cone is a border, which needs rays; points know the plane for the sun in clear water only.
        plain = never and not (
            shadowed.any() or isinstance(light, Spot) or (around.settings.points and through.rows.total > 1)
        )
        plane = around.plane if plain else None
        if plane is not None:
            through = PlaneLander(plane, texels[0].chart, source, *medium, fresnel)
        self._rows, self._power = through.rows, source.power
        self._ways = [Way(self.water, lambda: around.edges, shadowed, through)]
        if mirrors.any():
            part, twins = part_of(self.water, scene.water.twins, mirrors)
            smooth = part.triangles is part.normal_triangles
            edges = partial(Edges.of, part.triangles, twins, smooth)
            self._ways.append(Way(part, edges, shadowed[mirrors], lander(mirrored=True)))

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
        each = self.disc.left * square / len(self._ways)
        work = [splat(*w.start(), sheet, texel_area, each, sight) for w in self._ways]
        lost, met, errors = zip(*work, strict=True)
        flux = sheet.flux()
        beside = sheet.landed - flux.sum(1)
        lost[0]["missed"] += np.where(beside > _ROUNDING * sheet.landed, beside, 0.0)
        flux = self.disc.blur(flux)
        owned, *books = self._own(flux, lost, met)
        arrived = flux.sum() / sheet.channels / area
        error = sum(errors) / square * (mean / arrived) ** 2 if arrived > 0 else 0.0
        light = owned.mean(1) / np.concatenate([t.area for t in self.texels])
        return owned, *books, error + self.disc.doubt(light)

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
        """As `throw`, from single directions within the sun's disc, or places on a piece of a lamp."""
        suns = within_disc(self.light, max(_DIRECTIONS // among(self.light), 1), rng)
        flux, lost, met, used = 0.0, {}, 0.0, 0
        for sun in suns:
            part = Lit(sun, self._around)
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
            named = {cause: own[cause] for cause in _NAMED if cause in own}
            books["reflected"] = books["reflected"] - (all_of_it - sum(own.values()) + sum(named.values()))
            books |= {cause: books.get(cause, 0.0) + watts for cause, watts in named.items()}
        owned, beside = gather_all(self.texels, flux)
        books["missed"] = books["missed"] + beside
        coloured = {cause: self._in_colour(watts) for cause, watts in books.items()}
        return self._in_colour(owned).T, coloured, met[0] * self._power

    def _in_colour(self, flux):
        """Flux [W] (3, ...) in red, green and blue of flux (C, ...) [W for 1 W/m^2] of the channels."""
        return (flux[self._rows.channel].T * self._power).T


class Way:
    """A way that light takes from the water, through it or off it: from which LitWater, what makes its Edges, where it
    may lie in a shadow (T,), and the Lander that follows it."""

    def __init__(self, water, edges, shadowed, lander):
        self.water, self._edges, self.shadowed, self.lander = water, edges, shadowed, lander
        self._points = None

    def start(self):
        """What `splat` takes of it."""
        return self.water, self._edges(), self.lander, self.shadowed

    def share(self, water):
        """Share of the light on `water` that starts this way."""
        total = water.area.sum()
        return self.water.area.sum() / total if total else 0.0

    def points(self, scene, texels):
        """What lands points that go this way."""
        if self._points is None:
            if self.lander.certain:
                self._points = Plane(texels[0], scene.eta, self.water, self.lander.plane, self.lander.fresnel)
            else:
                self._points = Rays(self.lander, len(texels), texels[0].resolution, self.water, self.shadowed)
        return self._points
