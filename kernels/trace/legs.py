"""Which triangle each leg of a path meets first, with a ray cast only where something other than planes may be met.

Light that leaves a convex body outwards never meets it again, see `convex`; if it passes by the boxes round all else
that is not flat, planes alone tell where it ends, see `flats`. Light inside a convex body that nothing else reaches
into can but meet that body: it is sought in that body alone, and backwards, from outside, where the ray library finds
it in little more than half of the time. All other legs are rays among everything.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS, Tracer
from .convex import dents
from .flats import Flats, parts
from .picks import chosen, pick, some

_FLATS, _BOXES = 4, 6  # of a scene, at most: they take a fifth and a tenth of the time of a ray
_SHALLOW = 0.1  # sine of dents: light in a body with deeper ones may leave it by one and come in again
_WIDER = 1e-6  # of the extent: boxes are wider than what they hold, for single precision
_TINY = 1e-300  # directions: none is 0


class Legs:
    """Of meshes, numbered and with triangles numbered through them in their order, with a Tracer over all; bends: the
    number of the first that bends light; facet (3,T): unit normals of those, out of what they enclose.

    left (2T,) of bending triangles, twice their numbers, plus one on the side of their normals: what light is marked
    with that leaves there, 0 if it may meet anything, m + 1 if it does not meet mesh m again, -m - 1 if it meets mesh m
    and nothing else. steep (T,): the cosine at which it has to leave for that, at least, and dented: whether that tells
    anything. known: whether anything is marked.
    """

    def __init__(self, meshes, tracer, bends, facet):
        self._meshes, self._tracer, self._within = meshes, tracer, {}
        self._base = np.cumsum([0, *(len(mesh.triangles) for mesh in meshes)])
        self._first = first = self._base[bends]
        self.left, self.steep = np.zeros((self._base[-1] - first, 2), np.int16), np.full(self._base[-1] - first, -2.0)
        flat = [parts(mesh, base) for mesh, base in zip(meshes, self._base, strict=False)]
        self._boxes = [(m, *_box(meshes[m])) for m in range(len(meshes)) if flat[m] is None]
        known = [part for mesh in flat if mesh is not None for part in mesh]
        self.known = len(known) <= _FLATS and len(self._boxes) <= _BOXES and bends < len(meshes)
        if not self.known:
            return
        self._flats = Flats(known)
        for m in range(bends, len(meshes)):
            own = slice(self._base[m] - first, self._base[m + 1] - first)
            if not len(meshes[m].triangles) or self._within_reach(m, (k for k, *_ in self._boxes)):
                continue
            if flat[m] is not None:
                self.left[own] = m + 1 if len(flat[m]) == 1 else 0
                continue
            steep = dents(meshes[m].positions, meshes[m].triangles, facet[:, own])
            if steep is not None:
                self.steep[own], self.left[own, 1] = steep, m + 1
                if steep.max() <= _SHALLOW and not self._within_reach(m, range(len(meshes))):
                    self.left[own, 0] = -m - 1
                    self._within[m] = None
        self.known, self.dented = bool(self.left.any()), bool((self.steep > 0).any())
        self.left = self.left.ravel()

    def mark(self, m):
        """By what light is known that leaves mesh m: it changes if another mesh comes into its box, or leaves it."""
        own = self.left.reshape(-1, 2)[self._base[m] - self._first : self._base[m + 1] - self._first]
        return own[0].tolist() if len(own) else []

    def first(self, start, direction, left):
        """The first triangle (k,) that rays from starts along directions (3,k) meet, MISS for none, which left (k,)
        what they are marked with; one number for all where nothing is marked."""
        return self._found(start, direction, left, _first)[0]

    def hits(self, start, direction, left):
        """As `first`; how far (k,) it is to there; and whether (k,) it may be another one, see `Tracer.hits`: planes
        tell one only, and so does a mesh that is alone."""
        return self._found(start, direction, left, _hits)

    def _found(self, start, direction, left, cast):
        """What `cast` gives, each (k,), by ways that cast fewer rays."""
        if not self.known or not left.ndim:
            return cast(self._tracer, start, direction)
        found = np.empty(len(left), np.int32), np.empty(len(left)), np.empty(len(left), bool)
        for at, leg in ((chosen(left > 0), self._outside), (chosen(left < 0), self._inside), (chosen(left == 0), None)):
            if some(at):
                way = pick(start, at), pick(direction, at)
                own = cast(self._tracer, *way) if leg is None else leg(*way, pick(left, at), cast)
                _put(found, at, own)
        return found

    def _outside(self, start, direction, left, cast):
        """As `_found`, of what left convex bodies."""
        end, far = self._flats.first(start, direction)
        near = np.zeros(len(left), bool)
        inverse = 1 / np.where(direction == 0, _TINY, direction)
        for m, low, high in self._boxes:
            others = left != m + 1
            if others.any():
                others &= _crosses(low, high, start, inverse, far)
                near |= others
        return self._sought((end, far, np.zeros(len(end), bool)), near, start, direction, cast)

    def _inside(self, start, direction, left, cast):
        """As `_found`, of what is in convex bodies alone."""
        found = np.empty(len(left), np.int32), np.empty(len(left)), np.zeros(len(left), bool)
        for m in self._within:
            at = chosen(left == -m - 1)
            if some(at):
                tracer, back = self._tracer_of(m), -pick(direction, at)
                end, *far = cast(tracer, pick(start, at) - tracer.extent * back, back)[:2]
                end[end != MISS] += self._base[m]
                _put(found, at, (end, *(tracer.extent - distance for distance in far)))
        return self._sought(found, found[0] == MISS, start, direction, cast)

    def _sought(self, found, again, start, direction, cast):
        """What is found of rays, with those `again` (k,) cast among everything."""
        at = chosen(again)
        if some(at):
            _put(found, at, cast(self._tracer, pick(start, at), pick(direction, at)))
        return found

    def _tracer_of(self, m):
        """The Tracer over mesh m alone."""
        if self._within[m] is None:
            self._within[m] = Tracer(self._meshes[m].positions, self._meshes[m].triangles)
        return self._within[m]

    def _within_reach(self, m, others):
        """Whether any of the other meshes, by number, reaches into the box of mesh m."""
        low, high = _box(self._meshes[m], 0.0)
        boxes = (_box(self._meshes[k], 0.0) for k in others if k != m and len(self._meshes[k].triangles))
        return any((other_low < high).all() and (other_high > low).all() for other_low, other_high in boxes)


def _first(tracer, start, direction):
    return (tracer.first(start.T, direction.T),)


def _hits(tracer, start, direction):
    return tracer.hits(start.T, direction.T)


def _put(found, at, own):
    """Put what is own (n,) of a part `at` where it belongs of what is found (k,)."""
    for whole, part in zip(found, own, strict=False):
        whole[at] = part


def _box(mesh, wider=_WIDER):
    """Least and greatest coordinates (3,) of the triangles of a mesh, widened."""
    v = mesh.positions[mesh.triangles].reshape(-1, 3)
    low, high = v.min(0), v.max(0)
    off = wider * np.linalg.norm(high - low)
    return low - off, high + off


def _crosses(low, high, start, inverse, far):
    """Whether (k,) rays from starts (3,k), one over their directions (3,k), cross a box nearer than far (k,)."""
    near = 0.0
    for axis in range(3):
        a, b = (low[axis] - start[axis]) * inverse[axis], (high[axis] - start[axis]) * inverse[axis]
        near, far = np.maximum(near, np.minimum(a, b)), np.minimum(far, np.maximum(a, b))
    return near <= far
