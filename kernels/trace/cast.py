"""One light and the casters in it: points that set out on its entry cells, or beams, and the books of what they bring.

Flux counts as having come in where it meets its first caster; light that meets none is not this module's.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS
from ..scene import Sun
from ..splat.landing import Bins
from .arrivals import Arrivals
from .entry import Entry, points
from .follow import BLOCKED, CULLED, FAINT, TRAPPED, Follower, Rays
from .surfaces import Surfaces
from .volume import Box

CAUSES = {MISS: "missed", TRAPPED: "trapped", FAINT: "faint", CULLED: "culled", BLOCKED: "occluded"}
LOST = (*dict.fromkeys(CAUSES.values()), "absorbed")
_CELLS = 128  # of the entry, along its longer side
_FAINT = 1e-2  # of the tolerance: branches that carry less of a photon are not followed
_PILOT = 2  # points a cell that look where light meets casters


def over_casters(scene, texels, settings):
    """A Cast for each light of a Scene that has casters."""
    if not scene.casters:
        return []
    powers = [light.irradiance if isinstance(light, Sun) else light.intensity for light in scene.lights]
    surfaces = Surfaces(scene, np.sum([np.zeros(3), *powers], axis=0))
    box = Box(scene.volume) if scene.volume is not None else None
    return [Cast(scene, light, texels, surfaces, box, settings) for light in scene.lights]


class Cast:
    """As `splat.ways.Lit`: one light of a Scene over its casters, on Texels; surfaces: of the scene; box: of its
    volume, or None."""

    def __init__(self, scene, light, texels, surfaces, box, settings):
        self._surfaces, self._texels = surfaces, texels
        self._lamp = None if isinstance(light, Sun) else np.asarray(light.position, float)
        self._arrivals = Arrivals(scene.receivers, texels)
        self._follower = Follower(surfaces, settings.bounces, _FAINT * settings.tolerance, box)
        soups = [c.positions[c.triangles] for c in scene.casters]
        if box is not None:
            soups = [soup[box.touches(soup)] for soup in soups]
        wet = scene.water.positions[scene.water.triangles]
        meshes = (*scene.receivers, *scene.occluders, *scene.casters, scene.water)
        everything = np.concatenate([mesh.positions for mesh in meshes])
        self._entry = Entry(light, np.concatenate([*soups, wet]), everything, _CELLS)
        self.water, self._twins = self._entry.lit, self._entry.twins
        self._bins = Bins(len(texels) * self._arrivals.side**2, LOST, len(surfaces.sigma_a))

    def again(self):
        """How many rays met the water again, of those that met no caster: none is counted here."""
        return 0

    def throw(self, photons, rng):
        """Flux [W] per owned texel (K,3), per cause of loss and in all (3,), by about `photons` points, and how many
        there were."""
        used = 0
        for m, area in points(self.water, photons, rng):
            self._add(m, area)
            used += len(area)
        return *self._own(*self._bins.take()), used

    def _add(self, m, area):
        """Follow points m (3,n) of the entry that stand for area (n,), and leave what they bring in the bins."""
        rays, flux = self._start(m, area)
        for ended, end in self._follower.ends(rays):
            self._land(ended, end, np.take(flux, ended.photon))

    def _start(self, m, area):
        """The Rays of points m (3,n) of the entry that stand for area (n,), and their flux (n,) over the power."""
        towards, _, met = self.water.source.incident(m)
        direction = -np.broadcast_to(towards, m.shape)
        origin = m if self._lamp is None else np.broadcast_to(self._lamp[:, None], m.shape)
        return Rays.of(origin, direction, len(self._surfaces.sigma_a)), area * met

    def _land(self, rays, end, flux):
        """Leave Rays that end on `end` (k,), of photons of flux (k,), in the bins."""
        flux = flux * rays.share
        self._bins.met += flux.sum()
        receiving = (end >= 0) & (end < self._surfaces.receiving)
        at = np.flatnonzero(receiving)
        rays = rays.take(at)
        chart, x, y, distance, _ = self._arrivals.at(end[at], rays.origin, rays.direction)
        colour = self._surfaces.dimmed(rays.colour, rays.medium(), distance)
        side = self._arrivals.side
        i, j = (np.minimum(v, side - 1).astype(np.int64) for v in (x, y))
        self._bins.add((np.take(self._arrivals.image, chart) * side + j) * side + i, flux[at] * colour)
        self._bins.add_lost("absorbed", (flux[at] * (1 - colour)).sum(1))
        for code, cause in CAUSES.items():
            self._bins.add_lost(cause, flux[end == code].sum())
        self._bins.add_lost("occluded", flux[(end >= 0) & ~receiving].sum())

    def _own(self, flux, lost, met):
        """What the texels own (K,3) of the images' flux (C, texels), {cause: (3,)} and what came in (3,), in colour."""
        owned = []
        for k, channel in enumerate(flux):
            parts = [t.gather(part) for t, part in zip(self._texels, np.split(channel, len(self._texels)), strict=True)]
            lost["missed"][k] += sum(off for _, off in parts)
            owned.append(np.concatenate([own for own, _ in parts]))
        coloured = {cause: self._in_colour(watts) for cause, watts in lost.items()}
        return self._in_colour(np.stack(owned)).T, coloured, met * self.water.source.power

    def _in_colour(self, flux):
        """Flux (3, ...) [W] in red, green and blue of flux (C, ...) of the channels over the power."""
        return (flux[self._surfaces.channels].T * self.water.source.power).T
