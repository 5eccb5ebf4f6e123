"""What lands beams that are not split further - evenly, in pieces, as points - and the books of what they bring."""

from __future__ import annotations

import numpy as np

from ..chance import uniform
from .lander import DARK, LOST

_NEAR = 4.0  # texels: so far apart may rays that agree land, if those about them do not, for light to lie between them
PARTS = ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])  # of corners 0, 1, 2 and the middles 3, 4, 5 of their edges


class Deposit:
    """Leaves beams that a lander follows on a Sheet; finest [m^2]: of the texels. lost {cause: W (C,)}; met [W]: what
    meets the water; error: what is predicted of all."""

    def __init__(self, lander, sheet, finest):
        self._lander, self._sheet, self._rows, self._finest = lander, sheet, lander.rows, finest
        causes = (*LOST.values(), *self._rows.causes())
        self.lost = {cause: np.zeros(sheet.channels) for cause in causes}
        self.met, self.error = 0.0, 0.0

    def spread(self, corners, area, flux=None):
        """Spread beams of area (n,) over the triangles of Nodes corners (3n,): first, second, third corners; flux (C,n)
        is the mean of theirs, unless it is given."""
        if flux is None:
            flux = self.book(corners, np.arange(3 * len(area)).reshape(3, -1), area)
        chart, landed = corners.chart[: len(area)], np.flatnonzero(corners.chart[: len(area)] >= 0)
        x, y = (v.reshape(3, -1)[:, landed] for v in (corners.x, corners.y))
        self._sheet.add_triangles(chart[landed], x, y, flux[:, landed])

    def spread_evenly(self, corners, area, shade):
        """As `spread`, parts of area (n,) with three Nodes corners, by the light at three points in them, exact for
        quadratics; where the corners' goes nowhere, that of each point goes its own way."""
        inner = ([sum(getattr(c, v) for c in corners) / 6 + getattr(c, v) / 2 for c in corners] for v in "mn")
        m, n = (np.concatenate(v, 1) for v in inner)
        inner, rows = self._lander.land(m, n, np.tile(shade, 3)), np.arange(3 * len(area)).reshape(3, -1)
        at = np.flatnonzero(corners[0].chart >= 0)
        flux = self.book(inner, rows[:, at], area[at], corners[0].chart[at])
        first, second, third = (corner.take(at) for corner in corners)
        self.spread(first.join(second).join(third), area[at], flux)
        at = np.flatnonzero(corners[0].chart < 0)
        self.points(inner.take(rows[:, at].ravel()), np.tile(area[at] / 3, 3))

    def look(self, nodes, corner, area, shade):
        """Land beams corner (3,n) of area (n,), none of whose rays lands, by one point in each, anywhere: on the whole
        that is what hides there."""
        first, second = uniform(0, *sum(np.take(nodes.m, c, axis=1) for c in corner))
        out = first + second > 1
        first, second = np.where(out, 1 - first, first), np.where(out, 1 - second, second)
        shares = 1 - first - second, first, second
        inside = (sum(np.take(v, c, axis=1) * w for c, w in zip(corner, shares)) for v in (nodes.m, nodes.n))
        landed = self._lander.land(*inside, shade)
        self.error += ((area * self._rows.passed(landed.carried) / self._finest)[landed.chart >= 0] ** 2).sum()
        self.points(landed, area)

    def pieces(self, nodes, six, area):
        """Land beams six (6,n) of area (n,) by the four parts between their rays: where the three of one agree spread
        over their image, else as points."""
        parts = np.concatenate([np.take(six, part, axis=0) for part in PARTS], 1)
        chart, area = np.take(nodes.chart, parts), np.tile(area / 4, 4)
        near = np.maximum(*(np.ptp(np.take(v, parts), axis=0) for v in (nodes.x, nodes.y))) <= _NEAR
        whole = (chart[0] == chart[1]) & (chart[0] == chart[2]) & near
        at = np.flatnonzero(whole)
        self.spread(nodes.take(parts[:, at].ravel()), area[at])
        at = np.flatnonzero(~whole)
        self.points(nodes.take(parts[:, at].ravel()), np.tile(area[at] / 3, 3))

    def points(self, nodes, area):
        """Land beams of area (n,) as points."""
        flux = self.book(nodes, np.arange(len(area))[None], area)
        landed = np.flatnonzero(nodes.chart >= 0)
        self._sheet.add_points(nodes.chart[landed], nodes.x[landed], nodes.y[landed], flux[:, landed])

    def book(self, nodes, corner, area, chart=None):
        """Flux (C,n) that arrives of beams of area (n,) through nodes corner (k,n), on the chart (n,) of the first
        unless it is given; books what meets the water, what is reflected and absorbed, and what lands on no chart."""
        chart = np.take(nodes.chart, corner[0]) if chart is None else chart
        carried = area * sum(np.take(nodes.carried, c, axis=1) for c in corner) / len(corner)
        met, passed, flux = self._rows.met(carried, area), self._rows.passed(carried), self._rows.arriving(carried)
        for code, cause in LOST.items():
            of_it = np.flatnonzero(chart == code)
            if len(of_it):
                self.lost[cause] += (met if code in DARK else passed)[of_it].sum()
        lit, entered = ~np.isin(chart, DARK), self._rows.entered(carried)
        self.lost["reflected"] += met[lit].sum() - entered[lit].sum()
        if self._rows.again:
            self.lost["second_meeting"] += entered[lit].sum() - passed[lit].sum()
        if self._rows.absorbing:
            landed = chart >= 0
            self.lost["absorbed"] += passed[landed].sum() - flux[:, landed].sum(1)
        self.met += met.sum()
        return flux
