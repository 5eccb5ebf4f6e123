"""One light and the casters in it: points that set out on its entry cells, or beams, and the books of what they bring.

Flux counts as having come in where it meets its first caster; light that meets none is not this module's. For beams a
few points look first where the light goes, see `pilot.py`; each code that they do not land has beams of its own, from
the cells where the points found its light, and those round them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maps.texels import gather_all
from ..rays import MISS
from ..scene import Sun
from ..splat.beams import splat
from ..splat.edges import Edges
from ..splat.lander import BACK, LOST
from ..splat.lander import BEYOND as _BEYOND
from ..splat.landing import Bins
from ..splat.sheet import Sheet
from .arrivals import Arrivals
from .code_lander import CodeLander
from .entry import Entry, points
from .follow import BEYOND, BLOCKED, CULLED, FAINT, Follower, Rays
from .pilot import ALONG, Pilot
from .strays import Strays, odd
from .sun_disc import DiscCast, directions
from .surfaces import Surfaces
from .volume import Box

CAUSES = {MISS: "missed", BEYOND: LOST[_BEYOND], FAINT: "faint", CULLED: "culled", BLOCKED: "occluded"}
_LOST = (*dict.fromkeys(CAUSES.values()), "absorbed", LOST[BACK])
_SIGHT = 2.0  # texels: how wide cells of the entry are
_CELLS = 32, 256  # of the entry, along its longer side, at least and at most
_FAINT = 1e-2  # of the tolerance: branches that carry less of a photon are not followed
_NOISE, _ROUGH = 0.25, 0.4  # of the tolerance: for codes of little noise, and for rough light
_MORE = 256  # times the pilot's points, where light is rough, at most
_TINY = np.finfo(float).tiny
_ROUNDING = 1e-12


def over_casters(scene, texels, settings):
    """A Cast for each light of a Scene that has casters."""
    if not scene.casters:
        return []
    powers = [light.irradiance if isinstance(light, Sun) else light.intensity for light in scene.lights]
    surfaces = Surfaces(scene, np.sum([np.zeros(3), *powers], axis=0))
    box = Box(scene.volume) if scene.volume is not None else None

    def make(light, tolerance):
        return Cast(scene, light, texels, surfaces, box, replace(settings, tolerance=tolerance))

    casts = []
    for light in scene.lights:
        count, _ = directions(scene, light, texels)
        plain = count == 1
        casts.append(make(light, settings.tolerance) if plain else DiscCast(light, count, make, settings))
    return casts


def left_out(scene, texels, settings, work, casts):
    """Sentences (a list of str) on what the light of a Scene over its casters does not contain, by its books and those
    of its casts."""
    if not scene.casters:
        return []
    sentences = []
    for light in scene.lights:
        count, enough = directions(scene, light, texels)
        if count < enough:
            sentences.append(f"what is between {count} directions within the disc of '{light.name}', over casters")
    if not settings.points:
        sentences.append("in the estimated error, that errors of beams over casters add up where many meet in a focus")
    part = work.flux_lost[LOST[_BEYOND]].sum() / max(work.flux_in.sum(), np.finfo(float).tiny)
    if part > settings.tolerance:
        sentences.append(f"light that meets more than {settings.bounces} surfaces (bounces): {part:.1%} of all")
    return sentences + odd(scene, [cast.strays for cast in casts])


class Cast:
    """As `splat.ways.Lit`: one light of a Scene over its casters, on Texels; surfaces: of the scene; box: of its
    volume, or None. arrivals, follower, channels: what its landers use; strays: its Strays."""

    def __init__(self, scene, light, texels, surfaces, box, settings):
        self._surfaces, self._texels, self._settings = surfaces, texels, settings
        self._lamp = None if isinstance(light, Sun) else np.asarray(light.position, float)
        self._mask = 0 if self._lamp is None else surfaces.media.at(self._lamp)
        self.channels, self.arrivals = len(surfaces.sigma_a), Arrivals(scene.receivers, texels, surfaces)
        self.follower = Follower(surfaces, settings.bounces, _FAINT * settings.tolerance, box)
        soups = [c.positions[c.triangles] for c in scene.casters]
        if box is not None:
            soups = [soup[box.touches(soup)] for soup in soups]
        soup = np.concatenate([*soups, scene.water.positions[scene.water.triangles]])
        meshes = (*scene.receivers, *scene.occluders, *scene.casters, scene.water)
        self._texel_area = np.array([t.area.sum() / len(t.area) for t in texels])
        wide = np.ptp(soup, axis=(0, 1)).max(initial=0) / (_SIGHT * np.sqrt(self._texel_area.min()))
        cells = int(np.clip(wide, *_CELLS)) + 1
        self._entry = Entry(light, soup, np.concatenate([mesh.positions for mesh in meshes]), cells)
        self.water = self._entry.lit
        self.strays = Strays(scene, surfaces)
        self._bins = Bins(len(texels) * self.arrivals.side**2, _LOST, self.channels)

    def again(self):
        """How many rays met the water again, of those that met no caster: none is counted here."""
        return 0

    def throw(self, photons, rng):
        """Flux [W] per owned texel (K,3), per cause of loss and in all (3,), by about `photons` points, and how many
        there were."""
        used = 0
        for _, m, area in points(self.water, photons, rng):
            rays, met = self.start(m)
            for ended, end in self.follower.ends(rays):
                flux = np.take(area * met, ended.photon)
                self.strays.add(ended, end, flux * ended.share)
                self._land(ended, end, flux)
            used += len(area)
        return *self._own(*self._bins.take()), used

    def spread(self):
        """As `throw`, by beams, and points where light is rough; and their predicted relative mean squared error."""
        pilot = self._look()
        square = (pilot.arrived / sum(t.area.sum() for t in self._texels)) ** 2 * sum(len(t.area) for t in self._texels)
        tolerance = self._settings.tolerance * square
        quiet, error = pilot.quiet(_NOISE * tolerance)
        for rays, end, flux in pilot.points(quiet):
            self._land(rays, end, flux / rays.share)
        strong = np.setdiff1d(pilot.words, quiet).tolist()
        found, rough = ({word: pilot.cells(word)[k] for word in strong} for k in (0, 1))
        error += self._throw_rough(rough, pilot.noise(rough), _ROUGH * tolerance)
        sheet = Sheet(np.zeros(0, np.int64), len(self._texels), self.arrivals.side, self.channels)
        books, met, total = [], 0.0, sum(pilot.flux(word) for word in strong)
        for word in strong:
            near = self._entry.around(self._entry.around(found[word]) > 0) > 0
            left = (1 - _NOISE - _ROUGH) * tolerance * pilot.flux(word) / max(total, _TINY)
            lost, came, wrong = self._beam(word, near & ~rough[word], found[word], sheet, left)
            books, met, error = [*books, lost], met + came, error + wrong
        flux, lost, landed = self._bins.take()
        beams = sheet.flux()
        beside = sheet.landed - beams.sum(1)
        lost["missed"] = lost["missed"] + np.where(beside > _ROUNDING * sheet.landed, beside, 0.0)
        for book in books:
            lost |= {cause: lost.get(cause, 0.0) + watts for cause, watts in book.items()}
        return *self._own(flux + beams, lost, met + landed), error / square if square else 0.0

    def _look(self):
        """The Pilot of the entry."""
        rng = np.random.default_rng(self._settings.seed)
        found = []
        for cell, m, area in points(self.water, ALONG**2 * len(self.water.area) / 2, rng):
            rays, met = self.start(m)
            for ended, end in self.follower.ends(rays):
                flux = np.take(area * met, ended.photon) * ended.share
                self.strays.add(ended, end, flux)
                found.append((ended, end, flux, cell[ended.photon]))
        return Pilot(found, self._surfaces.receiving, self._entry, self._texel_area.min())

    def _throw_rough(self, rough, noise, most):
        """Land points where light is rough, {code: cells (n,) bool}, so many that their squared error, which is `noise`
        for as many as the pilot's, is `most`; returns what it is then."""
        cells = np.logical_or.reduce([np.zeros(len(self.water.area) // 2, bool), *rough.values()])
        if not cells.any():
            return 0.0
        more = np.clip(noise / most, 1, _MORE)
        lit, number = self._entry.part(cells)[0], np.flatnonzero(cells)
        rng = np.random.default_rng([self._settings.seed, 1])
        for cell, m, area in points(lit, more * ALONG**2 * len(number), rng):
            rays, met = self.start(m)
            for ended, end in self.follower.ends(rays):
                own = number[cell[ended.photon]]
                kept = np.logical_or.reduce([(ended.code == word) & of_it[own] for word, of_it in rough.items()])
                at = np.flatnonzero(kept)
                self._land(ended.take(at), end[at], np.take(area * met, ended.photon[at]))
        return noise / more

    def _beam(self, word, cells, found, sheet, tolerance):
        """What `beams.splat` returns for the light of one code from cells (n,) bool, of those where it was found (n,)
        and of others."""
        lander = CodeLander(self, word, np.repeat(found[cells], 2))
        sheet.image = lander.image
        lit, twins = self._entry.part(cells)
        shadowed = np.zeros(len(lit.area), bool)
        edges = Edges.of(lit.triangles, twins, True)
        return splat(lit, edges, lander, shadowed, sheet, self._texel_area, tolerance, _SIGHT)

    def start(self, m):
        """The Rays of points m (3,n) of the entry, and what meets them (n,) over the power."""
        towards, _, met = self.water.source.incident(m)
        direction = -np.broadcast_to(towards, m.shape)
        origin = m if self._lamp is None else np.broadcast_to(self._lamp[:, None], m.shape)
        return Rays.of(origin, direction, self.channels, self._mask), np.broadcast_to(met, m.shape[1])

    def landed(self, rays, end):
        """The `arrivals.Landed` of Rays that end (k,) on receivers."""
        return self.arrivals.of(rays, end)

    def spreads(self, m, way):
        """How much wider (k,) light is after its way (k,) than at points m (3,k) of the entry, if nothing bends it."""
        return np.ones(len(way)) if self._lamp is None else way / self.water.source.incident(m)[1]

    def _land(self, rays, end, flux):
        """Leave Rays that end on `end` (k,), of photons of flux (k,), in the bins."""
        flux = flux * rays.share
        self._bins.met += flux.sum()
        receiving = _receives(end, self._surfaces)
        landed, own = self.arrivals.of(rays, end), flux[receiving]
        back = landed.chart == BACK
        side = self.arrivals.side
        i, j = (np.minimum(v, side - 1).astype(np.int64) for v in (landed.x, landed.y))
        cell = (np.take(self.arrivals.image, np.maximum(landed.chart, 0)) * side + j) * side + i
        self._bins.add(cell[~back], (own * landed.colour)[:, ~back])
        self._bins.add_lost("absorbed", (own * (1 - landed.colour))[:, ~back].sum(1))
        self._bins.add_lost(LOST[BACK], own[back].sum())
        for code, cause in CAUSES.items():
            self._bins.add_lost(cause, flux[end == code].sum())
        self._bins.add_lost("occluded", flux[(end >= 0) & ~receiving].sum())

    def _own(self, flux, lost, met):
        """What the texels own (K,3) of the images' flux (C, texels), {cause: (3,)} and what came in (3,), in colour."""
        owned, beside = gather_all(self._texels, flux)
        lost["missed"] = lost["missed"] + beside
        coloured = {cause: self._in_colour(watts) for cause, watts in lost.items()}
        return self._in_colour(owned).T, coloured, met * self.water.source.power

    def _in_colour(self, flux):
        """Flux (3, ...) [W] in red, green and blue of flux (C, ...) of the channels over the power."""
        return (flux[self._surfaces.channels].T * self.water.source.power).T


def _receives(end, surfaces):
    """Whether (k,) rays end on receivers."""
    return (end >= 0) & (end < surfaces.receiving)
