"""Walkers: marching over triangles along the coplanarity curve until f changes sign, many at a time.

From a texel's point P the straight ray to the sun gives a first point on the curve (`conic_start.py`); the walk goes
from triangle to triangle (`conic_step.py`) until f changes sign, and finds the root inside (`conic_root.py`). After
source [1] of `conic.py`: it stops at the first root. Walkers of all texels step together; finished ones make room.
"""

from __future__ import annotations

import numpy as np

from ..status import Status
from .arcs import Arcs, Aside, Change, Walkers
from .conic import BACKWARD, FORWARD, is_negative, is_path, weights_on_edge
from .conic_root import solve_brackets
from .conic_start import begin, closed_curve_root
from .conic_step import follow_all, step

BLOCK = 1 << 14  # walkers at once: what a step touches stays in the second-level cache
_ENOUGH = BLOCK >> 3  # walkers for which it pays to follow their conics
_LOOK = 64  # steps between two looks at who is lost


class Walk:
    """First roots for receiver points p (3,K) in the sun's frame whose straight rays hit triangles first (K,), -1 none.

    After `run()`: triangle (K,), weights (K,3) and status (K,) of the roots (Status.LIT where there is one), and
    `steps`, the triangle steps that it took.
    """

    def __init__(self, surface, p, first, eta):
        count = p.shape[1]
        self.surface, self.p, self.first, self.eta = surface, p, first, eta
        self.triangle = np.full(count, -1)
        self.weights = np.zeros((count, 3))
        self.status = np.full(count, Status.NO_WATER, np.uint8)
        self.steps = 0
        self._stop = np.full(count, -1)  # the half-edge that would close a walker's curve
        self._below = np.zeros(count, bool)  # f is negative where it is
        self._begun, self._now = np.zeros(count, np.int64), 0  # when it started, in steps of all; not those set aside
        self._limit = 64 + int(16 * np.sqrt(len(surface.tail) / 3))

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
        walkers, self._odd, self._changes, self._arcs = Walkers.none(), Aside(), Aside(), Aside()
        while True:
            arcs = self._changes.count + self._arcs.count
            if len(walkers) < BLOCK // 2 and len(waiting):
                walkers = Walkers.concatenated([walkers, self._start(waiting[:BLOCK])])
                waiting = waiting[BLOCK:]
            elif self._odd.count and (self._odd.count >= _ENOUGH or not len(walkers)):
                walkers = Walkers.concatenated([walkers, self._follow()])
            elif arcs and (arcs >= BLOCK or not len(walkers)):
                walkers = Walkers.concatenated([walkers, self._solve()])
            elif len(walkers):
                walkers = self._advance(walkers)
            else:
                break

    def _start(self, ids):
        """Walkers ids (n,) that leave their first triangle; puts aside the arcs with a root in it."""
        start = begin(self.surface, self.first[ids], self.p[:, ids])
        self._finish(ids, start.upright, start.triangle, start.weights)
        closed = np.flatnonzero(start.closed & ~start.upright)
        if len(closed):
            self._close(ids[closed], start.triangle[closed], start.weights[closed])
        exits = (start.forward, start.backward) if self._sense == FORWARD else (start.backward, start.forward)
        end = weights_on_edge(*exits[0])
        below = is_negative(*self.surface.at(start.triangle, end), start.p, self.eta, self._sense)
        (edge, share), (stop, _) = exits
        edge = 3 * start.triangle + edge
        self._stop[ids], self._below[ids] = 3 * start.triangle + stop, below
        corners = np.stack([self.surface.tail[edge], self.surface.head[edge]])
        over, ends = self.surface.over[edge], self.surface.g_at_ends(edge, start.p)
        walkers = Walkers(ids, over, share, ends, corners)
        arcs = Arcs(walkers, start.triangle, *start.fan(), start.weights, end)
        open_ = ~(start.upright | start.closed)
        self._begun[ids] = np.where(below, 0, self._now)
        self._arcs.add(arcs.take(np.flatnonzero(open_ & below)))
        return self._cross(walkers, open_ & ~below)

    def _close(self, ids, triangle, weights):
        """Roots on curves that stay inside their first triangle."""
        weights = closed_curve_root(self.surface, triangle, weights, self.p[:, ids], self.eta)
        found = np.isfinite(weights).all(1)
        self._finish(ids, found, triangle, weights)
        self.status[ids[~found]] = Status.NO_ROOT

    def _advance(self, walkers):
        """One step of all walkers: those that go on; puts aside the others that have not come to an end."""
        self._now += 1
        w = walkers if self._now % _LOOK else self._without_lost(walkers)
        p = self.p.take(w.id, axis=1)
        exits, odd = step(self.surface, w.edge, p, w.ends, w.corners)
        self._begun[w.id[odd]] -= self._now
        self._odd.add(w.take(odd))
        return self._pass(w, exits, p, odd)

    def _follow(self):
        """As `_advance`, for the walkers in triangles with many crossings."""
        w = Walkers.concatenated(self._odd.take())
        self._begun[w.id] += self._now
        p = self.p.take(w.id, axis=1)
        exits, torn = follow_all(self.surface, w.edge, w.share, p)
        self.status[w.id[torn]] = Status.TORN
        return self._pass(w, exits, p, torn)

    def _pass(self, walkers, exits, p, but):
        """Walkers behind their exits, but for those `but` (k,) and where f changes sign: those are put aside."""
        w = walkers
        after = Walkers(w.id, exits.over, exits.share, exits.ends, exits.corners)
        below = is_negative(exits.m, exits.n, p, self.eta, self._sense)
        crossed = below != self._below.take(w.id)
        going = ~crossed
        crossed[but] = going[but] = False
        self.steps += len(w) - len(but)
        at = np.flatnonzero(crossed)
        self._below[w.id[at]] = below[at]
        self._begun[w.id[at]] -= self._now
        self._changes.add(Change(w.take(at), after.take(at)))
        return self._cross(after, going)

    def _without_lost(self, walkers):
        """The walkers but for those that took more steps than the mesh can justify."""
        lost = self._now - self._begun[walkers.id] > self._limit
        self.status[walkers.id[lost]] = Status.LOST
        return walkers.take(np.flatnonzero(~lost))

    def _cross(self, walkers, going):
        """Those at exits that are `going` (n,), on the other side; who leaves the mesh or comes back to the start ends
        here."""
        w, surface = walkers, self.surface
        ended = (w.edge < 0) | (w.edge == self._stop.take(w.id))
        at = np.flatnonzero(going & ended)
        self.status[w.id[at]] = np.where(w.edge[at] < 0, Status.OFF_THE_RIM, Status.NO_ROOT)
        share, ends, corners = 1 - w.share, w.ends[::-1], w.corners[::-1]
        if surface.turned is not None:
            turned = surface.turned.take(w.edge)
            share, ends = np.where(turned, w.share, share), np.where(turned, w.ends, ends)
            corners = np.where(turned, w.corners, corners)
        across = Walkers(w.id, w.edge, share, ends, corners).take(np.flatnonzero(going & ~ended))
        if not surface.smooth:
            across.ends = surface.g_at_ends(across.edge, self.p[:, across.id])
            across.corners = np.stack([surface.tail[across.edge], surface.head[across.edge]])
        return across

    def _solve(self):
        """Finish the arcs whose root is light; return the walkers of the others, past their arcs."""
        arcs = self._collect()
        beyond = arcs.beyond
        self._begun[beyond.id] += self._now
        brackets = arcs.brackets(self.p[:, beyond.id], self._sense)
        weights = solve_brackets(self.surface, brackets, self.eta)
        m, n = self.surface.at(brackets.triangle, weights)
        good = (weights.min(1) > -1e-6) & is_path(m, n, brackets.p, self.eta)
        self._finish(beyond.id, good, brackets.triangle, weights)
        return self._cross(beyond, ~good)

    def _collect(self):
        """The Arcs that were put aside."""
        arcs, changes = self._arcs.take(), self._changes.take()
        return Arcs.concatenated([*arcs, *([Arcs.of(self.surface, changes)] if changes else [])])

    def _finish(self, ids, found, triangle, weights):
        ids = ids[found]
        self.triangle[ids], self.weights[ids] = triangle[found], weights[found]
        self.status[ids] = Status.LIT
