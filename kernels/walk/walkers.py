"""Walkers: marching over triangles along the coplanarity curve until f changes sign, many at a time.

From a texel's point P the straight ray to the sun gives a first point on the curve (`conic_start.py`); the walk goes
from triangle to triangle (`conic_step.py`) until f changes sign, and finds the root inside (`conic_root.py`). After
source [1] of `conic.py`: it stops at the first root. Walkers of all texels step together; finished ones make room.
"""

from __future__ import annotations

import numpy as np

from ..status import Status
from .conic import BACKWARD, FORWARD, is_path, objective, weights_on_edge
from .conic_root import Brackets, fan, solve_brackets
from .conic_start import begin, closed_curve_root
from .conic_step import step

BLOCK = 1 << 14  # walkers at once: what a step touches stays in the second-level cache


class Walk:
    """First roots for receiver points p (3,K) in the sun's frame whose straight rays hit triangles first (K,), -1 none.

    After `run()`: triangle (K,), weights (K,3) and status (K,) of the roots (Status.LIT where there is one), and
    `steps`, the triangle steps that it took.
    """

    def __init__(self, surface, p, first, eta):
        self.surface, self.p, self.first, self.eta = surface, p, first, eta
        self.triangle = np.full(p.shape[1], -1)
        self.weights = np.zeros((p.shape[1], 3))
        self.status = np.full(p.shape[1], Status.NO_WATER, np.uint8)
        self.steps = 0
        self._limit = 64 + int(16 * np.sqrt(len(surface.k) / 3))

    def run(self):
        """Walk the whole set, the likelier way first; returns self."""
        for way in (FORWARD, BACKWARD):
            if way == FORWARD:
                waiting = np.flatnonzero(self.first >= 0)
            else:
                waiting = np.flatnonzero(np.isin(self.status, (Status.OFF_THE_RIM, Status.TORN, Status.LOST)))
            self._sense = way
            self._walk(waiting)
        return self

    def _walk(self, waiting):
        walkers, arcs, held = _Walkers.none(), [], 0
        while len(waiting) or len(walkers.id) or held:
            if len(walkers.id) < BLOCK // 2 and len(waiting):
                started, arc = self._start(waiting[:BLOCK])
                waiting = waiting[BLOCK:]
                walkers = walkers.join(started)
            elif len(walkers.id):
                walkers, arc = self._advance(walkers)
            else:
                arc = None
            if arc is not None and len(arc):
                arcs.append(arc)
                held += len(arc)
            if held >= BLOCK or (held and not len(walkers.id) and not len(waiting)):
                walkers = walkers.join(self._solve(arcs))
                arcs, held = [], 0

    def _start(self, ids):
        """Walkers that leave their first triangle, and arcs with a root in it."""
        start = begin(self.surface, self.first[ids], self.p[:, ids])
        self._finish(ids, start.upright, start.triangle, start.weights)
        closed = np.flatnonzero(start.closed & ~start.upright)
        if len(closed):
            self._close(ids[closed], start.triangle[closed], start.weights[closed])
        exits = (start.forward, start.backward) if self._sense == FORWARD else (start.backward, start.forward)
        end = weights_on_edge(*exits[0])
        f = objective(*self.surface.at(start.triangle, end), start.p, self.eta, self._sense)
        (edge, share), (stop, _) = exits
        begun = np.zeros(len(ids), np.int64)
        edge, stop = 3 * start.triangle + edge, 3 * start.triangle + stop
        ends = self.surface.g_at_ends(edge, start.p)
        state = _Walkers(ids, edge, share, stop, f, start.p, begun, ends)
        arcs = _Arcs(state, start.triangle, *start.fan(), start.weights, end)
        open_ = ~(start.upright | start.closed)
        return self._cross(state, open_ & (f >= 0)), arcs.take(np.flatnonzero(open_ & (f < 0)))

    def _close(self, ids, triangle, weights):
        """Roots on curves that stay inside their first triangle."""
        weights = closed_curve_root(self.surface, triangle, weights, self.p[:, ids], self.eta)
        found = np.isfinite(weights).all(1)
        self._finish(ids, found, triangle, weights)
        self.status[ids[~found]] = Status.NO_ROOT

    def _advance(self, walkers):
        """One step of all walkers: those that go on, and the arcs on which f changed sign."""
        self.steps += len(walkers.id)
        w = walkers
        leave, share, ends, torn = step(self.surface, w.edge, w.share, w.p, w.ends)
        m, n = self.surface.between(np.take(self.surface.tail, leave), np.take(self.surface.head, leave), share)
        f = objective(m, n, w.p, self.eta, self._sense)
        after = _Walkers(w.id, leave, share, w.stop, f, w.p, w.steps + 1, ends)
        lost = after.steps > self._limit
        self.status[w.id[lost]] = Status.LOST
        self.status[w.id[torn]] = Status.TORN
        going = ~(torn | lost)
        crossed = going & ((f < 0) != (w.f < 0))
        at = np.flatnonzero(crossed)
        triangle, edge_in = np.divmod(w.edge[at], 3)
        edge_out = leave[at] % 3
        ends = weights_on_edge(edge_in, w.share[at]), weights_on_edge(edge_out, share[at])
        apex, turn = fan(edge_in, ends[0], edge_out, ends[1])
        arcs = _Arcs(after.take(at), triangle, apex, turn, *ends)
        return self._cross(after, going & ~crossed), arcs

    def _cross(self, walkers, going):
        """Those that are `going` (n,), over their edge; who leaves the mesh or comes back to the start ends here."""
        over = np.take(self.surface.over, walkers.edge)
        rim, round_ = going & (over < 0), going & (over == walkers.stop)
        self.status[walkers.id[rim]] = Status.OFF_THE_RIM
        self.status[walkers.id[round_]] = Status.NO_ROOT
        share, ends = 1 - walkers.share, walkers.ends[::-1]
        if self.surface.turned is not None:
            turned = np.take(self.surface.turned, walkers.edge)
            share, ends = np.where(turned, walkers.share, share), np.where(turned, walkers.ends, ends)
        walkers.edge, walkers.share, walkers.ends = over, share, ends
        walkers = walkers.take(np.flatnonzero(going & ~(rim | round_)))
        if not self.surface.smooth:
            walkers.ends = self.surface.g_at_ends(walkers.edge, walkers.p)
        return walkers

    def _solve(self, arcs):
        """Finish the arcs whose root is light; return the walkers of the others, past their arcs."""
        arcs = _Arcs.concatenated(arcs)
        brackets, beyond = arcs.brackets(self._sense), arcs.beyond
        weights = solve_brackets(self.surface, brackets, self.eta)
        m, n = self.surface.at(brackets.triangle, weights)
        good = (weights.min(1) > -1e-6) & is_path(m, n, beyond.p, self.eta)
        self._finish(beyond.id, good, brackets.triangle, weights)
        return self._cross(beyond, ~good)

    def _finish(self, ids, found, triangle, weights):
        ids = ids[found]
        self.triangle[ids], self.weights[ids] = triangle[found], weights[found]
        self.status[ids] = Status.LIT


class _Walkers:
    """Structure of arrays of walkers on a half-edge: id, edge and share where they are, stop (the half-edge that would
    close their curve), f there, p (3,n), steps, and ends (2,n), g at the ends of the edge."""

    def __init__(self, *arrays):
        self.id, self.edge, self.share, self.stop, self.f, self.p, self.steps, self.ends = arrays

    def arrays(self):
        return self.id, self.edge, self.share, self.stop, self.f, self.p, self.steps, self.ends

    @classmethod
    def none(cls):
        z, i = np.zeros(0), np.zeros(0, np.int64)
        return cls(i, i, z, i, z, np.zeros((3, 0)), i, np.zeros((2, 0)))

    def take(self, index):
        return _Walkers(*(np.take(a, index, axis=-1) for a in self.arrays()))

    def join(self, other):
        if not len(self.id):
            return other
        pairs = zip(self.arrays(), other.arrays(), strict=True)
        return _Walkers(*(np.concatenate([a, b], axis=-1) for a, b in pairs))


class _Arcs:
    """Arcs with a change of sign, as the first fields of `Brackets`, and the walkers that stand beyond them."""

    def __init__(self, beyond, *fields):
        self.beyond, self._fields = beyond, fields

    def __len__(self):
        return len(self.beyond.id)

    def take(self, index):
        return _Arcs(self.beyond.take(index), *(np.take(a, index, axis=0) for a in self._fields))

    def brackets(self, sense):
        return Brackets(*self._fields, self.beyond.p, sense)

    @classmethod
    def concatenated(cls, arcs):
        fields = [np.concatenate(parts) for parts in zip(*(a._fields for a in arcs), strict=True)]
        beyond = [np.concatenate(parts, axis=-1) for parts in zip(*(a.beyond.arrays() for a in arcs), strict=True)]
        return cls(_Walkers(*beyond), *fields)
