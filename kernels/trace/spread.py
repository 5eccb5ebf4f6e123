"""The light of one cast on its texels without noise that shows: by beams, and by points where light is rough.

A few points look first where the light goes, see `pilot.py`, and land what is weak; more of them land what is torn.
Beams follow the rest from the cells where the points found it and those round them, all codes at once.
"""

from __future__ import annotations

import numpy as np

from ..splat.beams import splat_parts
from ..splat.sheet import Sheet
from .brightness import Brightness
from .code_lander import CodeLander
from .codes import Codes
from .entry import points
from .pilot import PILOT, Pilot
from .scatter import Points, Scatter, keys
from .search import search

SIGHT = 2.0  # texels: how wide cells of the entry are
_POINTS = 0.7  # of the tolerance, for points
_ROUNDING = 1e-12
_SIX = [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]  # corners whose middles are a triangle's corners and its edges' middles


class Spread:
    """The work of `Cast.follow`."""

    def __init__(self, cast):
        self._cast, self._settings = cast, cast.settings
        texels = cast.texels
        self._shape = len(texels), cast.arrivals.side, cast.channels
        own = cast.part.of(texels)
        self._count, self._whole = sum(len(t.area) for t in own), sum(t.area.sum() for t in own)
        self._scatter = Scatter(cast.arrivals.image, *self._shape, cast.arrivals.box)

    def result(self):
        cast = self._cast
        found, left = search(cast, self._land_found)
        arrived = sum(part.share[self._receives(part.end)].sum() for part in (*found, *left))
        square = max(arrived / self._whole, cast.part.light) ** 2 * self._count
        tolerance = self._settings.tolerance * square
        pilot = self._pilot(found, _POINTS * tolerance)
        self._brightness = self._bright(found)
        self._land_pilot(found, pilot)
        del found, left
        self._land_more(pilot)
        flux, apart, landed = self._scatter.take()
        sheet = Sheet(np.zeros(0, np.int64), *self._shape)
        books, met, error = self._beam(pilot, sheet, (1 - _POINTS) * tolerance)
        error += self._doubt(apart)
        beams = sheet.flux()
        _, lost, came = cast.bins.take()
        beside = sheet.landed + landed - beams.sum(1) - flux.sum(1)
        lost["missed"] = lost["missed"] + np.where(beside > _ROUNDING * (sheet.landed + landed), beside, 0.0)
        lost |= {cause: lost.get(cause, 0.0) + watts for cause, watts in books.items()}
        return *cast.own(flux + beams, lost, met + came), error / square if square else 0.0

    def _receives(self, end):
        return (end >= 0) & (end < self._cast.surfaces.receiving)

    def _pilot(self, found, most):
        """The Pilot of what is found."""
        parts = [(np.zeros(0, np.int64),) * 4 + (np.zeros(0),) * 2]
        for part in found:
            at, flux = self._receives(part.end), part.share
            arriving, light = np.where(at, flux, 0.0), np.zeros(len(flux))
            texel = self._cast.texel_area[self._cast.arrivals.receiver(part.end[at])]
            light[at] = flux[at] / np.maximum(texel, part.across[at] ** 2)
            where = part.end.astype(np.int64)
            where[at] = self._cast.arrivals.chart(part.end[at])
            parts.append((part.rays.code, part.rays.path, where, part.cell, light, arriving))
        return Pilot(*map(np.concatenate, zip(*parts, strict=True)), self._cast.entry, most)

    def _bright(self, found):
        """The Brightness of all that is found."""
        arrivals, bright = self._cast.arrivals, Brightness(self._cast.texels, self._cast.part.mine)
        for part in found:
            landed = arrivals.of(part.rays, part.end)
            bright.add(arrivals.receiver(part.end[landed.ray]), landed.x, landed.y, part.share[landed.ray])
        return bright

    def _land_pilot(self, found, pilot):
        """Land the pilot's points whose light it is to land."""
        start = 0
        for part in found:
            stop = start + len(part.end)
            self._land_found(part.take(np.flatnonzero(pilot.kind[start:stop] == PILOT)))
            start = stop

    def _land_found(self, found, *level):
        """Land a part of what was found by cells of a level, if they are not the last."""
        apart = [np.full(len(found.end), 1 + k) for k in level]
        ways = self._cast.ways(found.rays, found.end)
        self._land(ways, found.flux, found.stratum, found.across, ways.code, *apart)

    def _land_more(self, pilot):
        """Land more points where light is rough."""
        cast = self._cast
        side, words, want = pilot.points()
        codes = Codes(words)
        for cell, stratum, m, area in points(cast.water, side, cast.entry.place, self._settings.seed):
            ways = cast.follow_codes(m, cast.entry.keys(m), codes, want[cell])
            at = ways.photon
            across = cast.across(m[:, at], area[at], ways.way)
            self._land(ways, np.take(area * cast.met(m), at), stratum[:, at], across, ways.code, side[cell[at]])

    def _land(self, ways, flux, stratum, across, *way):
        """Scatter Ways of photons of flux (k,) and strata (2,k), as wide as across (k,) [m]."""
        landed, arrives = self._cast.book(ways, flux)
        at = np.flatnonzero(ways.chart >= 0)
        stratum = stratum[:, at]
        wide = across[at] / np.sqrt(self._cast.texel_area[self._cast.arrivals.image[landed.chart]])
        key = keys(stratum, *(np.take(part, at) for part in way), landed.path, landed.chart)
        self._scatter.add(Points(key, stratum.sum(0) % 2 == 0, landed.chart, landed.x, landed.y, arrives, wide))

    def _doubt(self, apart):
        """Squared error of points, from the difference (C, texels) of their halves."""
        area = np.repeat(self._cast.texel_area, self._cast.arrivals.side**2)
        return ((apart.mean(0) / area) ** 2).sum()

    def _beam(self, pilot, sheet, tolerance):
        """{cause: W (C,)} of what beams do not bring to the sheet, what they start with, and their error."""
        lit, parts = self._cast.water, [(np.zeros(0, np.int64),) * 2 + (np.zeros(0, bool),)]
        words = []
        for word, cells, torn in pilot.beams():
            triangle = np.flatnonzero(np.repeat(cells, 2) & (lit.area > 0))
            parts.append((triangle, np.full(len(triangle), len(words)), ~torn[triangle // 2]))
            words.append(word)
        triangle, number, clear = map(np.concatenate, zip(*parts, strict=True))
        lander = CodeLander(self._cast, words, self._brightness)
        sheet.image = lander.image
        a, b = (np.take(lit.points, lit.triangles[triangle][:, k].T.ravel(), axis=0).T for k in _SIX)
        area = lit.area[triangle]
        return splat_parts((a + b) / 2, area, lander, number, clear, sheet, self._cast.texel_area, tolerance, SIGHT)
