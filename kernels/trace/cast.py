"""One light and the casters in it: points that set out on its entry cells, or beams, and the books of what they bring.

Flux counts as having come in where it meets its first caster; light that meets none is not this module's.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..area_lamps import among
from ..maps.texels import gather_all
from ..rays import MISS
from ..scene import Sun
from ..splat.lander import BACK, LOST
from ..splat.lander import BEYOND as _BEYOND
from ..splat.landing import Bins
from .apart import Apart
from .arrivals import Arrivals
from .entry import BLOCK, CELLS, Entry, evenly, points
from .follow import BEYOND, BLOCKED, CULLED, FAINT, Follower, Rays
from .kept_light import Followed, without_power
from .part import Near, Part, sizes
from .picks import chosen, pick
from .spread import SIGHT, Spread
from .strays import Strays
from .sun_disc import DiscCast, directions
from .surfaces import Surfaces
from .volume import Box
from .ways import Ways

CAUSES = {MISS: "missed", BEYOND: LOST[_BEYOND], FAINT: "faint", CULLED: "culled", BLOCKED: "occluded"}
_LOST = (*dict.fromkeys(CAUSES.values()), "absorbed", LOST[BACK])
_WITHIN = 0.99  # of what is seen at a glance: the cells of the entry
_FAINT = 1e-2  # of the tolerance, about: branches that carry less of a photon are not followed


def over_casters(scene, texels, settings, kept=None):
    """A Cast for each light of a Scene that has casters; kept: the KeptLight of the frames before."""
    if not scene.casters:
        return []
    powers = [light.irradiance if isinstance(light, Sun) else light.intensity for light in scene.lights]
    power = np.sum([np.zeros(3), *powers], axis=0)
    surfaces = Surfaces(scene, power)
    box = Box(scene.volume) if scene.volume is not None else None

    lit = power > 0

    def make(light, tolerance, number=None, part=None):
        cast = Cast(scene, light, texels, surfaces, box, replace(settings, tolerance=tolerance), part)
        if kept is not None and number is not None:
            cast.known = kept.known(light, number, lit, part)
        return cast

    def one(light, part):
        count, _ = directions(scene, light, part.of(texels), settings.tolerance)
        if count == 1:
            return make(light, settings.tolerance * among(light), 0, part)
        return DiscCast(light, count, partial(make, part=part), settings)

    casts, alike = [], sizes(texels)
    for light in scene.lights:
        casts.append(one(light, Part(alike[0])) if len(alike) == 1 else Apart(partial(one, light), alike, texels))
        if kept is not None:
            casts[-1].keep = partial(kept.of, scene, light, lit, texels, settings)
    return casts


def _faint(tolerance):
    """What share of a photon is too little: a power of two, which stays as it is while the tolerance shifts a bit."""
    return 2.0 ** np.round(np.log2(_FAINT * tolerance))


class Cast(Followed):
    """As `splat.ways.Lit`: one light of a Scene over its casters, on Texels; surfaces: of the scene; box: of its
    volume, or None; part: the Part of the light that counts. entry, arrivals, follower, channels, texel_area (images,)
    [m^2] and bins: what `Spread` uses; finer: how often cells are halved by the `search`; strays: its Strays."""

    def __init__(self, scene, light, texels, surfaces, box, settings, part):
        self.part, self._near = part, Near(part.of(scene.receivers))
        self.surfaces, self.texels, self.settings = surfaces, texels, settings
        self._scene, self._light, self.known = scene, light, None
        self._lamp = None if isinstance(light, Sun) else np.asarray(light.position, float)
        self._state = 0 if self._lamp is None else surfaces.crossings.state(surfaces.media.at(self._lamp))
        self.channels, self.arrivals = len(surfaces.sigma_a), Arrivals(scene.receivers, texels, surfaces)
        self.follower = Follower(surfaces, settings.bounces, _faint(settings.tolerance), box)
        soups = [c.positions[c.triangles] for c in scene.casters]
        if box is not None:
            soups = [soup[box.touches(soup)] for soup in soups]
        soup = np.concatenate([*soups, scene.water.positions[scene.water.triangles]])
        meshes = (*scene.receivers, *scene.occluders, *scene.casters, scene.water)
        area = np.array([t.area.sum() / len(t.area) for t in texels])
        self.texel_area = np.where(part.mine, area, area[part.mine].max())
        width, first = _WITHIN * SIGHT * np.sqrt([area[part.mine].min(), max(area[part.mine].min(), part.coarsest)])
        extent = np.ptp(soup, axis=(0, 1)).max() if len(soup) else 0.0  # none, where the volume holds no caster
        wanted, start = extent / width, np.clip(extent / first, *CELLS)
        self.finer = int(np.ceil(np.log2(max(wanted / start, 1)))) if part.coarsest else 0
        self.entry = Entry(light, soup, np.concatenate([mesh.positions for mesh in meshes]), first)
        self.water = self.entry.lit
        self.strays = Strays(scene, surfaces)
        self.bins = Bins(len(texels) * self.arrivals.side**2, _LOST, self.channels)

    def again(self):
        """How many rays met the water again, of those that met no caster: none is counted here."""
        return 0

    def throw(self, photons, rng):
        """Flux [W] per owned texel (K,3), per cause of loss and in all (3,), by about `photons` points, and how many
        there were."""
        used = 0
        seed = int(rng.integers(1 << 62))
        for _, _, m, area in points(self.water, evenly(self.water, photons), self.entry.place, seed):
            rays, met = self.start(m)
            for ended, end in self.follower.ends(rays):
                flux = np.take(area * met, ended.photon)
                self.strays.add(ended, end, flux * ended.share)
                landed, arrives = self.book(self.ways(ended, end), flux)
                self.bins.add(self.arrivals.texel(landed), arrives)
            used += len(area)
        return *self.in_colour(*self.own(*self.bins.take())), used

    def follow(self):
        """See `Followed`: by beams, and points where light is rough."""
        if self.known is not None:
            self.known.begin(self._inputs(), self._scene, self.surfaces)
        return *Spread(self).result(), self.strays

    def _inputs(self):
        """What ways depend on beside meshes."""
        scene = self._scene
        optics = tuple(c.material for c in scene.casters), scene.eta, scene.sigma_a, scene.volume
        charts = tuple((t.resolution, t.chart) for t in self.texels)
        counted = self.follower.bounces, self.follower.faint, self.part.mine, self.part.rest
        return without_power(self._light), counted, self.surfaces.channels, optics, charts

    def counts(self, end):
        """Whether (k,) rays that end on `end` (k,) are of this Part of the light."""
        if self.part.whole:
            return np.ones(len(end), bool)
        counts = np.full(len(end), self.part.rest)
        at = np.flatnonzero((end >= 0) & (end < self.surfaces.receiving))
        counts[at] = np.take(self.part.mine, self.arrivals.receiver(end[at]))
        return counts

    def ends(self, rays, codes, want, trail=None):
        """As `Follower.ends`, what counts of it."""
        for ended, end in self.follower.ends(rays, codes, want, trail):
            at = chosen(self.counts(end))
            yield ended.take(at), pick(end, at)

    def divide(self, cells):
        """Light that is of interest enters by these cells (n,) bool alone: make them finer."""
        self.entry = self.entry.finer(cells)
        self.water = self.entry.lit

    def passes(self, rays, end, m, area):
        """Whether (k,) Rays that end on `end` (k,), of points m (3,k) that stand for area (k,), light or nearly light
        what counts."""
        distance = self.surfaces.distance(rays.origin, rays.direction, end)
        return self._near.passed(rays, distance, lambda way: np.sqrt(area) * self.spreads(m, way))

    def gone(self, rays, end):
        """How far (k,) [m] Rays went until they end on `end` (k,)."""
        return rays.way + self.surfaces.distance(rays.origin, rays.direction, end)

    def across(self, m, area, way):
        """How wide (k,) [m] light of points m (3,k) that stand for area (k,) is after its way (k,) [m], if nothing
        bends it; 0 where the cells are as fine as the texels."""
        return np.sqrt(area) * self.spreads(m, way) if self.finer else np.zeros(len(way))

    def start(self, m):
        """The Rays of points m (3,n) of the entry, and what meets them (n,) over the power."""
        towards, _, met = self.water.source.incident(m)
        direction = -np.broadcast_to(towards, m.shape)
        origin = m if self._lamp is None else np.broadcast_to(self._lamp[:, None], m.shape)
        return Rays.of(origin, direction, self.channels, self._state), np.broadcast_to(met, m.shape[1])

    def met(self, m):
        """What meets points m (3,k) of the entry, over the power."""
        return np.broadcast_to(self.water.source.incident(m)[2], m.shape[1])

    def landed(self, rays, end):
        """The `arrivals.Landed` of Rays that end (k,) on receivers."""
        return self.arrivals.of(rays, end)

    def spreads(self, m, way):
        """How much wider (k,) light is after its way (k,) than at points m (3,k) of the entry, if nothing bends it."""
        return np.ones(len(way)) if self._lamp is None else way / self.water.source.incident(m)[1]

    def ways(self, rays, end, codes=None):
        """The Ways of Rays that end (k,). Where there is no chart, chart is BACK of a receiver's triangle, or what
        `Follower.ends` says, BLOCKED for all occluders."""
        landed = self.landed(rays, end)
        chart = np.where(end >= 0, BLOCKED, end)
        chart[landed.ray] = landed.chart
        x, y, way = np.zeros((3, len(end)))
        x[landed.ray], y[landed.ray], way[landed.ray] = landed.x, landed.y, landed.way
        colour = np.ones((self.channels, len(end)))
        colour[:, landed.ray] = landed.colour
        code = rays.code if codes is None else np.take(codes.number, rays.code)
        return Ways(rays.photon, code, chart, x, y, way, rays.share, colour, rays.path)

    def follow_codes(self, m, keys, codes, want):
        """The Ways, in their order, of points m (3,k) of the entry, of keys (k,) from there, that ask for Codes want
        (k,)."""
        known = None if self.known is None else self.known.ways(m, keys, codes, want, self._trace)
        if known is not None:
            return known
        return Ways.join(
            [
                self._trace(m[:, k : k + BLOCK], codes, want[k : k + BLOCK]).later(k)
                for k in range(0, max(m.shape[1], 1), BLOCK)
            ]
        ).ordered()

    def _trace(self, m, codes, want, trail=None):
        """The Ways of points m (3,k) that ask for Codes want (k,), told to a Trail."""
        ended = self.ends(self.start(m)[0], codes, want, trail)
        return Ways.join([Ways.none(self.channels), *(self.ways(rays, end, codes) for rays, end in ended)])

    def book(self, ways, flux):
        """What of Ways, of photons of flux (n,), lands on fronts of receivers, and what arrives of it (C,k); all else
        is booked."""
        flux, at = flux * ways.share, np.flatnonzero(ways.chart >= 0)
        landed, own = ways.take(at), flux[at]
        self.bins.met += flux.sum()
        self.bins.add_lost(LOST[BACK], flux[ways.chart == BACK].sum())
        self.bins.add_lost("absorbed", (own * (1 - landed.colour)).sum(1))
        for code, cause in CAUSES.items():
            self.bins.add_lost(cause, flux[ways.chart == code].sum())
        return landed, own * landed.colour

    def own(self, flux, lost, met):
        """What the texels own (C,K) of the images' flux (C, texels), what is lost with that beside the charts, and what
        came in, over the power."""
        owned, beside = gather_all(self.texels, flux)
        return owned, lost | {"missed": lost["missed"] + beside}, met

    def in_colour(self, flux, lost, met):
        """Flux [W] (K,3), {cause: (3,)} and (3,) of what is over the power: flux (C,K), lost {cause: (C,)} and met."""
        power = self.water.source.power

        def coloured(watts):
            return (watts[self.surfaces.channels].T * power).T

        return coloured(flux).T, {cause: coloured(watts) for cause, watts in lost.items()}, met * power
