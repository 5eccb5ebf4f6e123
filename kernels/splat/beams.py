"""Exact coverage: each water triangle's beam is shared among the texels by the area that its image covers.

Rays through a triangle's corners and the middles of its edges land on the receivers. Where all six land on one of them
and the image is as nearly affine as the tolerance asks, the beam's flux is spread evenly over the image in UV space and
deposited by exact area coverage (`maps/coverage.py`): folds, flips and overlaps need no special case, there is no
noise, and the flux is kept. Elsewhere - on the border of a chart, of an object or of a shadow, or where the predicted
error is large - the triangle is split in four. A part of a texel's size that straddles a border is cut there
(`border.py`); the few that straddle more than one land point by point.
"""

from __future__ import annotations

import numpy as np

from .border import cut, straddlers
from .drift import Drift
from .lander import DARK, LOST, OTHER, SPREAD, UNLIT
from .mesh_nodes import MeshNodes
from .prediction import bend, cut_off, predict

_CUT = 2.0  # texels on the receiver: parts smaller than this that straddle one border are cut there
_STRAIGHT = 0.05  # texels: how far the edges of larger parts than a texel may bend for that
_POINT = 0.25  # texels: parts smaller than this that straddle more land point by point
_DEPTH = 14  # splits at most
_MANY = 1 << 18  # parts of which it pays to look again whether anything hides in them
_JUMP = 16.0  # texels: parts that are cut and land further apart than this are looked at for seams
_HIDDEN = 1.0  # texels: parts smaller than this none of whose rays lands, near light that does, land by a point
_NEAR = 4.0  # texels: so far apart may rays that agree land, if those about them do not, for light to lie between them
_EVEN = np.array([1, 1, 1, 3, 3, 3]) / 12  # shares of the six rays: six triangles have a corner, two a middle
_PARTS = ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])  # of corners 0, 1, 2 and the middles 3, 4, 5 of their edges
_EDGES = [0, 3, 1, 4, 2, 5, 3, 4, 5], [3, 1, 4, 2, 5, 0, 4, 5, 3]  # between which the parts' middles 6 to 14 lie
_MIDDLES = ([6, 14, 11], [7, 8, 12], [13, 9, 10], [12, 13, 14])  # of the parts' edges


def splat(lit, edges, lander, shadowed, sheet, texel_area, tolerance, sight):
    """Leave the flux [W for 1 W/m^2] of all beams on a Sheet; returns {cause: W (C,)} of what reaches no receiver, what
    meets the water [W], and the predicted error.

    lit: LitWater and its Edges; shadowed (T,) bool from `may_be_shadowed`; texel_area (images,) [m^2] of each map's
    texels; tolerance: sum of squared errors over all texels, for light of 1 W/m^2; sight [texel]: larger parts are
    split where something may hide between rays, though all six agree.
    """
    work = _Work(lander, sheet, texel_area, tolerance, sight)
    if not lit.area.any():
        return work.lost, work.met, work.error
    mesh = MeshNodes(lit, edges, lander, shadowed)
    large = (2 * lit.area >= sight**2 * work.finest) | work.rows.varies
    clear = mesh.clear(lander, shadowed, large)
    work.grazing = lander.grazing or (bool((work.rows.passed(mesh.carried) == 0).any()) and not work.rows.varies)
    work.uneven |= work.grazing
    rest = work.settle_mesh(mesh, lit.area, clear)
    return _by_parts(work, *mesh.part(rest), lit.area[rest], shadowed[rest], clear[rest])


def splat_parts(m, area, lander, shade, clear, sheet, texel_area, tolerance, sight):
    """As `splat`, of beams that share no mesh: from triangles of area (n,) [m^2], by points m (3,6n) at their first,
    second and third corners, and the middles of the edges from these; shade (n,): what the lander is to know of each;
    clear (n,) bool: nothing can hide between its rays."""
    work = _Work(lander, sheet, texel_area, tolerance, sight)
    work.grazing = lander.grazing
    nodes = lander.land(m, np.zeros((0, m.shape[1])), np.tile(shade, 6))
    return _by_parts(work, nodes, np.arange(m.shape[1]).reshape(6, -1), area, shade, clear)


def _by_parts(work, nodes, six, area, shade, clear):
    """Deposit triangles six (6,n) of Nodes, split until they are ready; returns what `splat` does."""
    for depth in range(_DEPTH + 1):
        rest = work.settle(nodes, six, area, shade, clear, depth == _DEPTH)
        if not len(rest):
            break
        nodes, six = _split(work.lander, nodes, np.take(six, rest, axis=1), shade[rest])
        area, shade, clear = np.tile(area[rest] / 4, 4), np.tile(shade[rest], 4), np.tile(clear[rest], 4)
        some = np.flatnonzero(~clear)
        if len(some) > _MANY and not work.lander.grazing:  # else what is small and far keeps all of a beam in work
            clear[some] = work.lander.clear(nodes.m, nodes.n, six[:3, some].T, shade[some])
    return work.lost, work.met, work.error + (work.drift.error() if work.drift else 0.0)


def _split(lander, nodes, six, shade):
    """Nodes and six (6,4n) of the four parts of each of n triangles six (6,n)."""
    count = six.shape[1]
    known = nodes.take(six.ravel())  # six rows of n
    m, n = (v.reshape(len(v), 6, count) for v in (known.m, known.n))
    fresh = [((v[:, _EDGES[0]] + v[:, _EDGES[1]]) / 2).reshape(len(v), len(_EDGES[0]) * count) for v in (m, n)]
    landed = lander.land(*fresh, np.tile(shade, len(_EDGES[0])))
    parts = np.concatenate([_PARTS, _MIDDLES], 1).T  # (6,4)
    return known.join(landed), (parts[:, :, None] * count + np.arange(count)).reshape(6, -1)


class _Work:
    """The sheet, the books, and what decides whether a triangle is ready."""

    def __init__(self, lander, sheet, texel_area, tolerance, sight):
        self.lander, self.sheet, self.sight = lander, sheet, sight
        self.texel_area, self.finest = np.asarray(texel_area), np.min(texel_area)
        self.rows, self.uneven, self.grazing = lander.rows, lander.rows.varies, False
        causes = (*LOST.values(), *self.rows.causes())
        self.lost = {cause: np.zeros(sheet.channels) for cause in causes}
        self.met, self.error, self.tolerance = 0.0, 0.0, tolerance
        self.drift = Drift(len(self.texel_area), sheet.resolution) if lander.hides else None
        self._chance = np.random.default_rng(0)
        self.spent = 0.0  # of the tolerance: parts that are too small to be split have no choice

    def settle_mesh(self, mesh, area, clear):
        """Deposit the triangles of the water's own mesh that are ready, all but those of the largest errors, such that
        the sum of those that stay is within the tolerance; returns the indices of the others."""
        lit, corner = area > 0, mesh.edges.corner
        chart = np.take(mesh.chart, corner[0])
        x, y = np.take(mesh.x, corner), np.take(mesh.y, corner)
        six = mesh.six(slice(None)) if self.uneven else corner  # the middles give the mean of a quadratic
        error = self._predict(mesh.bent(), chart, x, y, area, self._light(mesh, six))
        ready = lit & self._ready(chart, np.where(lit, error, 0.0), self._size(mesh, six, area), clear)
        at = np.flatnonzero(ready)
        flux = self._book(mesh, np.take(six[-3:], at, axis=1), area[at])
        landed = np.flatnonzero(chart[at] >= 0)
        at = at[landed]
        self.error += error[at].sum()
        self.spent = self.error
        if len(at) < len(lit):
            x, y, flux = np.take(x, at, axis=1), np.take(y, at, axis=1), np.take(flux, landed, axis=1)
        self.sheet.add_mesh(mesh, at, x, y, flux)
        return np.flatnonzero(lit & ~ready)

    def settle(self, nodes, six, area, shade, clear, last):
        """Deposit the triangles six (6,n) that are ready; returns the indices of those to split."""
        chart, x, y = (np.take(v, six) for v in (nodes.chart, nodes.x, nodes.y))
        same = (chart[1:] == chart[0]).all(0)
        bent = np.where(same, np.maximum(bend(x), bend(y)), np.inf)
        error = self._predict(bent, chart[0], x[:3], y[:3], area, self._light(nodes, six))
        sheet = same & np.isfinite(error)  # else it is torn
        size = self._size(nodes, six, area)
        if self.lander.grazing:  # rays that part are worth following as far as the light of single points would show
            flux = area * np.take(self.rows.passed(nodes.carried), six).max(0) / self.finest
            error = np.where(sheet, error, (_EVEN**2).sum() * flux * flux)
        weight = self.lander.weight(chart, *(np.take(v, six) for v in (nodes.x, nodes.y)))
        whole = self._ready(chart[0], error, size, clear, weight)
        at, ordered = self._to_cut(nodes, six, chart, area, size, clear, whole)
        cut = np.zeros(len(area), bool)
        if len(at):
            cut[at] = self._cut(nodes, ordered, area[at], shade[at], size[at])
        small = last | (self._widest(nodes, six, area) < _POINT * self.lander.fine)
        done = (whole | small) & ~cut
        unseen = done & sheet & ~clear & self._dark(chart[0]) if self.lander.hides else np.zeros(len(area), bool)
        self._look(nodes, six[:3, unseen], area[unseen], shade[unseen])
        if self.drift:
            self._drift(nodes, six, chart, area, np.flatnonzero(done & sheet & (chart[0] >= 0)))
        at = np.flatnonzero(done & sheet & ~unseen)
        self.error += error[done & np.isfinite(error)].sum()
        self.spent += error[whole & ~cut].sum()
        weigh = slice(3, 6) if self.uneven else slice(0, 3)  # the middles give the mean of a quadratic
        self._spread(nodes.take(six[:3, at].ravel()), area[at], self._book(nodes, six[weigh][:, at], area[at]))
        torn = done & ~sheet
        if self.lander.hides:
            dark = torn & ~same & (chart < 0).all(0)
            self._look(nodes, six[:3, dark], area[dark], shade[dark])
            at = np.flatnonzero(torn & ~same & ~dark)
            self._pieces(nodes, six[:, at], area[at])
            torn &= same
        at = np.flatnonzero(torn)
        self._points(nodes.take(six[:, at].ravel()), (_EVEN[:, None] * area[at]).ravel())
        return np.flatnonzero(~(done | cut))

    def _drift(self, nodes, six, chart, area, at):
        """Tell the Drift of the triangles `at` of those six (6,n), on charts (6,n), of area (n,)."""
        six, image = six[:, at], self._image(chart[0, at])
        x, y, passed = (np.take(v, six) for v in (nodes.x, nodes.y, self.rows.passed(nodes.carried)))
        self.drift.add(image, x, y, passed[3:].mean(0) * area[at] / np.take(self.texel_area, image))

    def _to_cut(self, nodes, six, chart, area, size, clear, whole):
        """Which triangles six (6,n), on charts (6,n), of area (n,) and sizes (n,) [texel], to cut at the border
        that they straddle, of those that are not ready whole (n,), and their nodes (6,k), lone corner first.

        Those that are larger than a texel only where the edge beyond the border lands as straight as the cut is, and
        where nothing else can hide, see `_ready`.
        """
        straddling, order = straddlers(chart)
        fit = (size < 1) | ((self._widest(nodes, six, area) < _CUT) & (clear | (size < self.sight)))
        if self.grazing:
            fit &= size < _POINT * self.lander.fine  # what passes falls steeply towards the back of a normal
        at = np.flatnonzero(straddling & fit & ~whole)
        ordered = np.take_along_axis(six[:, at], order[:, at], axis=0)
        x, y = (np.take(v, ordered[[1, 2, 4]]) for v in (nodes.x, nodes.y))
        off = np.maximum(*(np.abs(v[2] - (v[0] + v[1]) / 2) for v in (x, y)))
        kept = np.flatnonzero((size[at] < 1) | (off < _STRAIGHT))
        return at[kept], ordered[:, kept]

    def _light(self, nodes, six):
        """Mean and range (n,) over beams six (6,n) of what passes the water, where it is uneven; else 1 and 0."""
        if not self.uneven:
            return 1.0, 0.0
        passed = np.take(self.rows.passed(nodes.carried), six)
        return passed.mean(0), np.ptp(passed, axis=0)

    def _size(self, nodes, six, area):
        """How many texels (n,) beams are across, where they meet the receiver if the light of a lamp spreads them."""
        return self._widest(nodes, six, area) if self.rows.varies else self._across(nodes, six, area)

    def _across(self, nodes, six, area):
        """How many of the finest texels that their rays land on (n,) beams are across; where none lands, of the
        coarsest."""
        if len(self.texel_area) == 1:
            return np.sqrt(2 * area / self.finest)
        chart = np.take(nodes.chart, six)
        texel = np.where(chart < 0, self.texel_area.max(), np.take(self.texel_area, self._image(chart))).min(0)
        return np.sqrt(2 * area / texel)

    def _widest(self, nodes, six, area):
        """As `_across`, on the receiver and not where the beams start."""
        return self._across(nodes, six, area) * np.take(nodes.spread, six).max(0)

    def _ready(self, chart, error, size, clear, weight=None):
        """Whether (n,) beams, of errors `error` or inf where their rays do not agree, need no closer look; clear (n,):
        nothing can hide between their rays.

        Those of the least errors, such that their sum takes no more than half of what is left of the tolerance: the
        other half is for the parts of the others.
        """
        known = np.isfinite(error)
        most = cut_off(error[known], (self.tolerance - self.spent) / 2, None if weight is None else weight[known])
        seen = (clear & (chart != UNLIT)) | (size < np.where(self._dark(chart), _HIDDEN * self.lander.fine, self.sight))
        return known & (error <= (most if weight is None else most * weight)) & seen

    def _dark(self, chart):
        """Whether (n,) beams whose rays all end so, by their chart, may yet hold light that lands elsewhere."""
        return chart < 0 if self.lander.hides else chart == OTHER

    def _image(self, chart):
        return np.take(self.lander.image, np.maximum(chart, 0))

    def _predict(self, bent, chart, x, y, area, light):
        """Sum of squared errors (n,) that spreading evenly leaves on the texels, see `prediction.predict`; inf where
        rays do not agree."""
        flux = area / np.take(self.texel_area, self._image(chart))
        error = np.where(chart < 0, 0.0, predict(bent, x, y, flux, light, self.sheet.resolution))
        return np.where(np.isfinite(bent), error, np.inf)

    def _spread(self, corners, area, flux=None):
        """Spread beams of area (n,) over the triangles of Nodes corners (3n,): first, second, third corners; flux (C,n)
        is the mean of theirs, unless it is given."""
        if flux is None:
            flux = self._book(corners, np.arange(3 * len(area)).reshape(3, -1), area)
        chart, landed = corners.chart[: len(area)], np.flatnonzero(corners.chart[: len(area)] >= 0)
        x, y = (v.reshape(3, -1)[:, landed] for v in (corners.x, corners.y))
        self.sheet.add_triangles(chart[landed], x, y, flux[:, landed])

    def _look(self, nodes, corner, area, shade):
        """Land beams corner (3,n) of area (n,), none of whose rays lands, by one point in each, anywhere: on the whole
        that is what hides there."""
        first, second = self._chance.random((2, len(area)))
        out = first + second > 1
        first, second = np.where(out, 1 - first, first), np.where(out, 1 - second, second)
        shares = 1 - first - second, first, second
        inside = (sum(np.take(v, c, axis=1) * w for c, w in zip(corner, shares)) for v in (nodes.m, nodes.n))
        landed = self.lander.land(*inside, shade)
        self.error += ((area * self.rows.passed(landed.carried) / self.finest)[landed.chart >= 0] ** 2).sum()
        self._points(landed, area)

    def _pieces(self, nodes, six, area):
        """Land beams six (6,n) of area (n,) by the four parts between their rays: where the three of one agree spread
        over their image, else as points."""
        parts = np.concatenate([np.take(six, part, axis=0) for part in _PARTS], 1)
        chart, area = np.take(nodes.chart, parts), np.tile(area / 4, 4)
        near = np.maximum(*(np.ptp(np.take(v, parts), axis=0) for v in (nodes.x, nodes.y))) <= _NEAR
        whole = (chart[0] == chart[1]) & (chart[0] == chart[2]) & near
        at = np.flatnonzero(whole)
        self._spread(nodes.take(parts[:, at].ravel()), area[at])
        at = np.flatnonzero(~whole)
        self._points(nodes.take(parts[:, at].ravel()), np.tile(area[at] / 3, 3))

    def _points(self, nodes, area):
        """Land beams of area (n,) as points."""
        flux = self._book(nodes, np.arange(len(area))[None], area)
        landed = np.flatnonzero(nodes.chart >= 0)
        self.sheet.add_points(nodes.chart[landed], nodes.x[landed], nodes.y[landed], flux[:, landed])

    def _book(self, nodes, corner, area, chart=None):
        """Flux (C,n) that arrives of beams of area (n,) through nodes corner (k,n), on the chart (n,) of the first
        unless it is given; books what meets the water, what is reflected and absorbed, and what lands on no chart."""
        chart = np.take(nodes.chart, corner[0]) if chart is None else chart
        carried = area * sum(np.take(nodes.carried, c, axis=1) for c in corner) / len(corner)
        met, passed, flux = self.rows.met(carried, area), self.rows.passed(carried), self.rows.arriving(carried)
        for code, cause in LOST.items():
            of_it = np.flatnonzero(chart == code)
            if len(of_it):
                self.lost[cause] += (met if code in DARK else passed)[of_it].sum()
        lit, entered = ~np.isin(chart, DARK), self.rows.entered(carried)
        self.lost["reflected"] += met[lit].sum() - entered[lit].sum()
        if self.rows.again:
            self.lost["second_meeting"] += entered[lit].sum() - passed[lit].sum()
        if self.rows.absorbing:
            landed = chart >= 0
            self.lost["absorbed"] += passed[landed].sum() - flux[:, landed].sum(1)
        self.met += met.sum()
        return flux

    def _cut(self, nodes, six, area, shade, size):
        """Cut triangles six (6,n), lone corner first, at their border; returns whether (n,) that could be done."""
        spread = np.take(nodes.spread, six).max(0)
        wide = np.where(spread < SPREAD, _JUMP + 2 * np.sqrt(2 * area / self.finest) * spread, np.inf)
        ((s, near_s, far_s), (t, near_t, far_t)), sound = cut(self.lander, nodes, six, shade, size, wide)
        alone, one, other = (nodes.take(six[k]) for k in range(3))
        pieces = (
            ((alone, near_s, near_t), s * t),
            ((far_s, one, other), 1 - s),
            ((far_s, other, far_t), s * (1 - t)),
        )
        take = np.flatnonzero(sound)
        for corners, share in pieces:
            first, second, third = (c.take(take) for c in corners)
            own = (area * share)[take]
            if self.grazing:
                self._spread_evenly((first, second, third), own, shade[take])
            else:
                self._spread(first.join(second).join(third), own)
        return sound

    def _spread_evenly(self, corners, area, shade):
        """As `_spread`, parts of area (n,) with three Nodes corners, by the light at three points in them, exact for
        quadratics; where the corners' goes nowhere, that of each point goes its own way."""
        inner = ([sum(getattr(c, v) for c in corners) / 6 + getattr(c, v) / 2 for c in corners] for v in "mn")
        m, n = (np.concatenate(v, 1) for v in inner)
        inner, rows = self.lander.land(m, n, np.tile(shade, 3)), np.arange(3 * len(area)).reshape(3, -1)
        at = np.flatnonzero(corners[0].chart >= 0)
        flux = self._book(inner, rows[:, at], area[at], corners[0].chart[at])
        first, second, third = (corner.take(at) for corner in corners)
        self._spread(first.join(second).join(third), area[at], flux)
        at = np.flatnonzero(corners[0].chart < 0)
        self._points(inner.take(rows[:, at].ravel()), np.tile(area[at] / 3, 3))
