"""What the walk keeps of its walkers between steps: where they stand, and the arcs on which they found a root."""

from __future__ import annotations

import numpy as np

from .conic import weights_on_edge
from .conic_root import Brackets, fan


class Walkers:
    """Structure of arrays of walkers: id; edge, the half-edge by which they enter a triangle, or come to across their
    exit; share along the entry or exit; ends (2,n), g at its tail and head, the records `corners` (2,n)."""

    def __init__(self, *arrays):
        self.id, self.edge, self.share, self.ends, self.corners = arrays

    @classmethod
    def none(cls):
        i = np.zeros((2, 0), np.int64)
        return cls(i[0], i[0], np.zeros(0), np.zeros((2, 0)), i)

    def __len__(self):
        return len(self.id)

    def take(self, index):
        return Walkers(*(a.take(index, axis=-1) for a in vars(self).values()))

    @classmethod
    def concatenated(cls, parts):
        return cls(*(np.concatenate(a, axis=-1) for a in zip(*(vars(part).values() for part in parts), strict=True)))


class Aside:
    """Parts of something, put aside until there are many."""

    def __init__(self):
        self._parts, self.count = [], 0

    def add(self, part):
        if len(part):
            self._parts.append(part)
            self.count += len(part)

    def take(self):
        """The parts, which are here no more."""
        parts, self._parts, self.count = self._parts, [], 0
        return parts


class Change:
    """The same walkers `before`, at their entries, and `after`, at the exits, where f has the other sign."""

    def __init__(self, before, after):
        self.before, self.after = before, after

    def __len__(self):
        return len(self.after)


class Arcs:
    """Arcs with a change of sign, as the first fields of `Brackets`, and the walkers that stand beyond them."""

    def __init__(self, beyond, *fields):
        self.beyond, self._fields = beyond, fields

    def __len__(self):
        return len(self.beyond)

    def take(self, index):
        return Arcs(self.beyond.take(index), *(np.take(a, index, axis=0) for a in self._fields))

    def brackets(self, p, sense):
        return Brackets(*self._fields, p, sense)

    @classmethod
    def of(cls, surface, changes):
        """The arcs of a list of Change."""
        before, after = (Walkers.concatenated([getattr(c, k) for c in changes]) for k in ("before", "after"))
        triangle, edge_in = np.divmod(before.edge, 3)
        edge_out = (surface.corner_records(triangle) == after.corners[0][:, None]).argmax(1)
        ends = weights_on_edge(edge_in, before.share), weights_on_edge(edge_out, after.share)
        return cls(after, triangle, *fan(edge_in, ends[0], edge_out, ends[1]), *ends)

    @classmethod
    def concatenated(cls, arcs):
        fields = [np.concatenate(parts) for parts in zip(*(a._fields for a in arcs), strict=True)]
        return cls(Walkers.concatenated([a.beyond for a in arcs]), *fields)
