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
from .deposit import PARTS, Deposit
from .drift import Drift
from .lander import SPREAD
from .mesh_nodes import MeshNodes
from .prediction import bend
from .readiness import Readiness

_CUT = 2.0  # texels on the receiver: parts smaller than this that straddle one border are cut there
_STRAIGHT = 0.05  # texels: how far the edges of larger parts than a texel may bend for that
_POINT = 0.25  # texels: parts smaller than this that straddle more land point by point
_DEPTH = 14  # splits at most
_MANY = 1 << 18  # parts of which it pays to look again whether anything hides in them
_JUMP = 16.0  # texels: parts that are cut and land further apart than this are looked at for seams
_EVEN = np.array([1, 1, 1, 3, 3, 3]) / 12  # shares of the six rays: six triangles have a corner, two a middle
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
        return work.books()
    mesh = MeshNodes(lit, edges, lander, shadowed)
    large = (2 * lit.area >= sight**2 * work.readiness.finest) | work.rows.varies
    clear = mesh.clear(lander, shadowed, large)
    work.grazing = lander.grazing or (bool((work.rows.passed(mesh.carried) == 0).any()) and not work.rows.varies)
    work.readiness.uneven |= work.grazing
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
    return work.books()


def _split(lander, nodes, six, shade):
    """Nodes and six (6,4n) of the four parts of each of n triangles six (6,n)."""
    count = six.shape[1]
    known = nodes.take(six.ravel())  # six rows of n
    m, n = (v.reshape(len(v), 6, count) for v in (known.m, known.n))
    fresh = [((v[:, _EDGES[0]] + v[:, _EDGES[1]]) / 2).reshape(len(v), len(_EDGES[0]) * count) for v in (m, n)]
    landed = lander.land(*fresh, np.tile(shade, len(_EDGES[0])))
    parts = np.concatenate([PARTS, _MIDDLES], 1).T  # (6,4)
    return known.join(landed), (parts[:, :, None] * count + np.arange(count)).reshape(6, -1)


class _Work:
    """Beams to be landed or split: whether they are ready is Readiness's matter, how they land Deposit's."""

    def __init__(self, lander, sheet, texel_area, tolerance, sight):
        self.lander, self.sheet, self.sight, self.rows, self.grazing = lander, sheet, sight, lander.rows, False
        self.readiness = Readiness(lander, texel_area, sheet.resolution, tolerance, sight)
        self.deposit = Deposit(lander, sheet, self.readiness.finest)
        self.drift = Drift(len(texel_area), sheet.resolution) if lander.hides else None

    def books(self):
        """What `splat` returns."""
        drifted = self.drift.error() if self.drift else 0.0
        return self.deposit.lost, self.deposit.met, self.deposit.error + drifted

    def settle_mesh(self, mesh, area, clear):
        """Deposit the triangles of the water's own mesh that are ready, all but those of the largest errors, such that
        the sum of those that stay is within the tolerance; returns the indices of the others."""
        lit, corner = area > 0, mesh.edges.corner
        chart = np.take(mesh.chart, corner[0])
        x, y = np.take(mesh.x, corner), np.take(mesh.y, corner)
        six = mesh.six(slice(None)) if self.readiness.uneven else corner  # the middles give the mean of a quadratic
        error = self.readiness.predict(mesh.bent(), chart, x, y, area, self.readiness.light(mesh, six))
        ready = lit & self.readiness.ready(
            chart, np.where(lit, error, 0.0), self.readiness.size(mesh, six, area), clear
        )
        at = np.flatnonzero(ready)
        flux = self.deposit.book(mesh, np.take(six[-3:], at, axis=1), area[at])
        landed = np.flatnonzero(chart[at] >= 0)
        at = at[landed]
        self.deposit.error += error[at].sum()
        self.readiness.spent = self.deposit.error
        if len(at) < len(lit):
            x, y, flux = np.take(x, at, axis=1), np.take(y, at, axis=1), np.take(flux, landed, axis=1)
        self.sheet.add_mesh(mesh, at, x, y, flux)
        return np.flatnonzero(lit & ~ready)

    def settle(self, nodes, six, area, shade, clear, last):
        """Deposit the triangles six (6,n) that are ready; returns the indices of those to split."""
        chart, x, y = (np.take(v, six) for v in (nodes.chart, nodes.x, nodes.y))
        same = (chart[1:] == chart[0]).all(0)
        bent = np.where(same, np.maximum(bend(x), bend(y)), np.inf)
        error = self.readiness.predict(bent, chart[0], x[:3], y[:3], area, self.readiness.light(nodes, six))
        sheet = same & np.isfinite(error)  # else it is torn
        size = self.readiness.size(nodes, six, area)
        if self.lander.grazing:  # rays that part are worth following as far as the light of single points would show
            flux = area * np.take(self.rows.passed(nodes.carried), six).max(0) / self.readiness.finest
            error = np.where(sheet, error, (_EVEN**2).sum() * flux * flux)
        weight = self.lander.weight(chart, *(np.take(v, six) for v in (nodes.x, nodes.y)))
        whole = self.readiness.ready(chart[0], error, size, clear, weight)
        at, ordered = self._to_cut(nodes, six, chart, area, size, clear, whole)
        cut = np.zeros(len(area), bool)
        if len(at):
            cut[at] = self._cut(nodes, ordered, area[at], shade[at], size[at])
        small = last | (self.readiness.widest(nodes, six, area) < _POINT * self.lander.fine)
        done = (whole | small) & ~cut
        unseen = (
            done & sheet & ~clear & self.readiness.dark(chart[0]) if self.lander.hides else np.zeros(len(area), bool)
        )
        self.deposit.look(nodes, six[:3, unseen], area[unseen], shade[unseen])
        if self.drift:
            self._drift(nodes, six, chart, area, np.flatnonzero(done & sheet & (chart[0] >= 0)))
        at = np.flatnonzero(done & sheet & ~unseen)
        self.deposit.error += error[done & np.isfinite(error)].sum()
        self.readiness.spent += error[whole & ~cut].sum()
        weigh = slice(3, 6) if self.readiness.uneven else slice(0, 3)  # the middles give the mean of a quadratic
        self.deposit.spread(
            nodes.take(six[:3, at].ravel()), area[at], self.deposit.book(nodes, six[weigh][:, at], area[at])
        )
        torn = done & ~sheet
        if self.lander.hides:
            dark = torn & ~same & (chart < 0).all(0)
            self.deposit.look(nodes, six[:3, dark], area[dark], shade[dark])
            at = np.flatnonzero(torn & ~same & ~dark)
            self.deposit.pieces(nodes, six[:, at], area[at])
            torn &= same
        at = np.flatnonzero(torn)
        self.deposit.points(nodes.take(six[:, at].ravel()), (_EVEN[:, None] * area[at]).ravel())
        return np.flatnonzero(~(done | cut))

    def _drift(self, nodes, six, chart, area, at):
        """Tell the Drift of the triangles `at` of those six (6,n), on charts (6,n), of area (n,)."""
        six, image = six[:, at], self.readiness.image(chart[0, at])
        x, y, passed = (np.take(v, six) for v in (nodes.x, nodes.y, self.rows.passed(nodes.carried)))
        self.drift.add(image, x, y, passed[3:].mean(0) * area[at] / np.take(self.readiness.texel_area, image))

    def _to_cut(self, nodes, six, chart, area, size, clear, whole):
        """Which triangles six (6,n), on charts (6,n), of area (n,) and sizes (n,) [texel], to cut at the border
        that they straddle, of those that are not ready whole (n,), and their nodes (6,k), lone corner first.

        Those that are larger than a texel only where the edge beyond the border lands as straight as the cut is, and
        where nothing else can hide, see `Readiness.ready`.
        """
        straddling, order = straddlers(chart)
        fit = (size < 1) | ((self.readiness.widest(nodes, six, area) < _CUT) & (clear | (size < self.sight)))
        if self.grazing:
            fit &= size < _POINT * self.lander.fine  # what passes falls steeply towards the back of a normal
        at = np.flatnonzero(straddling & fit & ~whole)
        ordered = np.take_along_axis(six[:, at], order[:, at], axis=0)
        x, y = (np.take(v, ordered[[1, 2, 4]]) for v in (nodes.x, nodes.y))
        off = np.maximum(*(np.abs(v[2] - (v[0] + v[1]) / 2) for v in (x, y)))
        kept = np.flatnonzero((size[at] < 1) | (off < _STRAIGHT))
        return at[kept], ordered[:, kept]

    def _cut(self, nodes, six, area, shade, size):
        """Cut triangles six (6,n), lone corner first, at their border; returns whether (n,) that could be done."""
        spread = np.take(nodes.spread, six).max(0)
        wide = np.where(spread < SPREAD, _JUMP + 2 * np.sqrt(2 * area / self.readiness.finest) * spread, np.inf)
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
                self.deposit.spread_evenly((first, second, third), own, shade[take])
            else:
                self.deposit.spread(first.join(second).join(third), own)
        return sound
