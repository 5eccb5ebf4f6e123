"""What is known of a light's ways over casters from the frame before: only those that a change can reach are followed
anew.

The idea is that of slabs [1], which are traced again where something in them has changed, with single photons in their
place. A photon is known by the point of the entry that it sets out from, bit for bit, and the codes that it is asked
for. What decides which points are followed, and what is made of them, knows nothing of this.

[1] De Barro et al., A Lightweight Photon Tracing Method for Visualising Caustics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..casters import Caster
from ..rays import SLOW
from ..unchanged import unchanged
from .entry import BLOCK
from .trail import Bodies, Trail, bounds, crossing, overlap
from .ways import Ways

_MIX = np.uint64(0x9E3779B97F4A7C15)
_WANT = np.uint64(24)  # bits of a key that tell where a point is


@dataclass
class _Part:
    """keys (n,) of what was asked for; count (n,) of its Ways, which lie one after the other, with numbers of their
    own for codes; and segments, see `Trail.take`, by n."""

    keys: np.ndarray
    count: np.ndarray
    ways: Ways
    photon: np.ndarray
    start: np.ndarray
    stop: np.ndarray

    def __len__(self):
        return len(self.keys)

    def size(self):
        """How many bytes it takes, about."""
        ways = sum(column.nbytes for column in vars(self.ways).values())
        return ways + sum(a.nbytes for a in (self.keys, self.count, self.photon, self.start, self.stop))

    def kept(self, keep):
        """Of it what is to be kept (n,)."""
        if keep.all():
            return self
        number = np.cumsum(keep) - 1
        at, own = np.flatnonzero(np.repeat(keep, self.count)), np.flatnonzero(keep[self.photon])
        segments = number[self.photon[own]].astype(np.int32), self.start[:, own], self.stop[:, own]
        return _Part(self.keys[keep], self.count[keep], self.ways.take(at), *segments)

    @classmethod
    def join(cls, parts):
        bases = np.cumsum([0, *map(len, parts)])
        keys, count, start, stop = (
            np.concatenate([getattr(part, name) for part in parts], axis=-1)
            for name in ("keys", "count", "start", "stop")
        )
        photon = np.concatenate([p.photon + np.int32(base) for p, base in zip(parts, bases, strict=False)])
        return cls(keys, count, Ways.join([part.ways for part in parts]), photon, start, stop)


class Known:
    """What is known of one light; most: bytes of it that may be kept, about."""

    def __init__(self, most=0):
        self.most, self._size, self._inputs, self._meshes = most, 0, None, ()
        self._part, self._parts, self._used, self._keeps = None, [], None, False
        self._words, self._marks = {}, []

    def begin(self, inputs, scene, surfaces):
        """Begin a frame of a Scene and its Surfaces: forget what a change of meshes reaches, and all if inputs differ,
        which are what else ways depend on."""
        meshes = surfaces.meshes
        legs, bends = surfaces.legs, len(scene.receivers) + len(scene.occluders)
        marks = [legs.mark(m) if m >= bends else [] for m in range(len(meshes))]
        frame = surfaces.tracer.centre, surfaces.tracer.extent, legs.known
        inputs = inputs, tuple(type(mesh) for mesh in meshes), frame
        first, same = self._inputs is None, unchanged(self._inputs, inputs)
        parts, still = [], True
        if same:
            same_marks = [one == other for one, other in zip(self._marks, marks, strict=True)]
            changed = [_changed(*three) for three in zip(self._meshes, meshes, same_marks, strict=True)]
            boxes = [box for own in changed for box in own]
            parts = self._sound(*self._reached(boxes), surfaces.tracer) if boxes else self._live()
            still = any(not own for own, mesh in zip(changed, meshes, strict=True) if isinstance(mesh, Caster))
        self._keeps = not SLOW and (first or same) and still
        self._inputs, self._meshes, self._marks, self._surfaces = inputs, meshes, marks, surfaces
        self._bodies = Bodies(scene.casters)
        self._parts, self._part = [], None
        self._size = sum(part.size() for part in parts)
        if parts:
            self._part = part = _Part.join(parts)
            self._order = np.argsort(part.keys, kind="stable")
            self._sorted, self._first = part.keys[self._order], np.cumsum(part.count) - part.count
            self._used = np.zeros(len(part), bool)
        of_caster = np.repeat(self._bodies.number, [len(c.triangles) for c in scene.casters])
        self._number = np.full(surfaces.water + len(scene.water.triangles) + 1, -1, np.int16)
        self._number[surfaces.solid : surfaces.water] = of_caster

    def size(self):
        """How many bytes are kept, about."""
        return self._size

    def _live(self):
        """The parts of what the last frame asked for."""
        old = [self._part.kept(self._used)] if self._part else []
        return [part for part in (*old, *self._parts) if len(part)]

    def _reached(self, boxes):
        """Low and high (n,3) of boxes of what changed, and of the bodies that these overlap."""
        low, high = (np.array(v) for v in zip(*boxes, strict=True))
        near = overlap(self._bodies.low, self._bodies.high, low, high).any(1)
        return np.concatenate([low, self._bodies.low[near]]), np.concatenate([high, self._bodies.high[near]])

    def _sound(self, low, high, tracer):
        """The parts of what the last frame asked for that do not come into boxes low, high (n,3); none if these are
        further off than ways are known."""
        low, high, sound = low - tracer.centre, high - tracer.centre, []
        if max(-low.min(), high.max()) > tracer.extent:
            return []
        for part in self._live():
            keep = np.ones(len(part), bool)
            keep[part.photon[crossing(part.start, part.stop, low, high, tracer.extent)]] = False
            if keep.any():
                sound.append(part.kept(keep))
        return sound

    def ways(self, m, keys, codes, want, trace):
        """The Ways, in their order, of points m (3,n) that ask for Codes want (n,), of keys (n,) from `places.keys`;
        trace gives those of some that are not known, given a Trail."""
        if not len(keys) or (self._part is None and not self._keeps):
            return None
        keys = keys ^ (_wanted(codes, want) >> _WANT)
        photon, found = np.arange(len(keys)), []
        if self._part is not None:
            photon, own = self._recall(keys, codes)
            found.append(own)
        for k in range(0, len(photon), BLOCK):
            own = photon[k : k + BLOCK]
            found.append(
                self._trace(np.take(m, own, axis=1), np.take(keys, own), codes, np.take(want, own), own, trace)
            )
        return Ways.join(found).ordered()

    def _recall(self, keys, codes):
        """Which photons (k,) are not known, and the Ways of the others."""
        at = np.minimum(np.searchsorted(self._sorted, keys), len(self._sorted) - 1)
        met = np.take(self._sorted, at) == keys
        entry = np.take(self._order, at[met])
        self._used[entry] = True
        count = np.take(self._part.count, entry)
        row = np.repeat(np.take(self._first, entry) - np.cumsum(count) + count, count) + np.arange(count.sum())
        ways = self._part.ways.take(row)
        ways.photon = np.repeat(np.flatnonzero(met), count)
        ids = self._ids(codes)
        number = np.zeros(len(self._words), np.int64)
        number[ids] = np.arange(len(ids))
        ways.code = number.take(ways.code)
        return np.flatnonzero(~met), ways

    def _ids(self, codes):
        """What words of Codes (c,) are known by."""
        return np.array([self._words.setdefault(word, len(self._words)) for word in codes.words], np.uint16)

    def _stored(self, ways, codes):
        """Ways as they are kept: whose they are is known, and codes are those of all calls."""
        none = np.zeros((0, len(ways.code)), np.uint8)
        return replace(ways, photon=none, code=self._ids(codes)[ways.code], chart=ways.chart.astype(np.int32))

    def _trace(self, m, keys, codes, want, photon, trace):
        """The Ways of points m (3,k) of keys (k,) that ask for want (k,), which are photons (k,)."""
        room = self._keeps and self._size < self.most
        trail = Trail(self._surfaces, self._number, len(keys)) if room else None
        ways = trace(m, codes, want, trail).ordered()
        if room:
            part = _Part(
                keys,
                np.bincount(ways.photon, minlength=len(keys)),
                self._stored(ways, codes),
                *trail.take(),
            )
            self._parts.append(part.kept(~trail.doubtful))
            self._size += part.size()
        ways.photon = photon[ways.photon]
        return ways


def _changed(old, new, same_marks):
    """Boxes, low and high (3,) each, round what differs of two meshes as they were and as they are, all of them where
    light that leaves them is marked differently; () for nothing."""
    if same_marks and unchanged(old, new):
        return ()
    if not same_marks or not np.array_equal(old.triangles, new.triangles):
        return tuple(bounds(mesh.positions, mesh.triangles) for mesh in (old, new) if len(mesh.triangles))
    touched = (old.positions != new.positions).any(1)[new.triangles].any(1)
    if hasattr(new, "normals"):
        touched |= _differ(old.normals[old.normal_triangles], new.normals[new.normal_triangles])
    if hasattr(new, "uvs"):
        touched |= _differ(old.uvs, new.uvs)
    return _joined(*(bounds(mesh.positions, mesh.triangles[touched]) for mesh in (old, new))) if touched.any() else ()


def _differ(one, other):
    """Whether (T,) values at corners of triangles (T,3,n) differ."""
    return (one != other).any((1, 2))


def _joined(one, other):
    """One box for two, low and high (3,) each, that overlap, or both."""
    if (np.maximum(one[0], other[0]) > np.minimum(one[1], other[1])).any():
        return one, other
    return ((np.minimum(one[0], other[0]), np.maximum(one[1], other[1])),)


def _wanted(codes, want):
    """A number (n,) for the set of words that is asked for by want (n,)."""
    every, mixed = np.array(codes.words, np.uint64) * _MIX, np.zeros(len(want), np.uint64)
    every ^= every >> np.uint64(29)
    every *= _MIX
    for k in range(0, len(every), 8):
        table = np.zeros(256, np.uint64)
        for bit, number in enumerate(every[k : k + 8]):
            table[np.arange(256) >> bit & 1 == 1] += number
        mixed += np.take(table, (want >> k & 0xFF))
    return mixed
