"""Which places rays come through, for as long as which their light is known: what changes elsewhere does not reach it.

Between its first meeting with a body and the time it leaves it, light stays in the box that bounds the body, for as
long as it meets nothing else. So only what comes from elsewhere, or goes there, is written down as it went.
"""

from __future__ import annotations

import numpy as np

from ..optics import dot

_MARGIN = 1e-5  # of the extent: what is so near counts as in the way
_FAR = 1e-6  # of how far off things are: float32 rounding
_MANY = 64  # bodies: of more all ways are written down
_STRAIGHT = np.float32(1e-20)  # segments, along an axis, at least
_BLOCK = 1 << 14


class Bodies:
    """Boxes round casters, joined where they overlap: low, high (boxes,3); number (casters,) of each caster's box."""

    def __init__(self, casters):
        whole = [bounds(c.positions, c.triangles) for c in casters if len(c.triangles)]
        self.number = np.full(len(casters), -1)
        self.low, self.high = np.zeros((2, 0, 3))
        if not 0 < len(whole) <= _MANY:
            return
        low, high = (np.array(v) for v in zip(*whole, strict=True))
        label = np.arange(len(whole))
        while True:
            groups, own = np.unique(label, return_inverse=True)
            self.low = np.array([low[label == k].min(0) for k in groups])
            self.high = np.array([high[label == k].max(0) for k in groups])
            over = overlap(self.low, self.high, self.low, self.high)
            first = over.argmax(1)
            if (first == np.arange(len(first))).all():
                break
            label = first[own]
        self.number[[len(c.triangles) > 0 for c in casters]] = own


def bounds(positions, triangles):
    """Low and high (3,) of triangles (T,3)."""
    corners = positions[triangles].reshape(-1, 3)
    return corners.min(0), corners.max(0)


def overlap(low, high, other_low, other_high):
    """Whether (n,m) boxes low, high (n,3) overlap others (m,3)."""
    return ((low[:, None] <= other_high) & (high[:, None] >= other_low)).all(2)


class Trail:
    """Segments of the rays of `count` photons over Surfaces with Bodies: photon (k,), start and stop (3,k) float32, as
    far as within the tracer's extent of its middle; and doubtful (count,) bool: whether a ray of theirs came so near an
    edge that another search might find another way."""

    def __init__(self, surfaces, bodies, count):
        self._solid = surfaces.solid
        self._number, self._extent = bodies, surfaces.tracer.extent
        self._centre = surfaces.tracer.centre[:, None]
        self._home, self._away, self._first = np.full(count, -1, np.int16), np.zeros(count, bool), True
        self.doubtful, self._parts = np.zeros(count, bool), []

    def add(self, rays, end, distance, doubtful):
        """Add Rays that meet triangles (k,), or MISS, after distance (k,); doubtful (k,)."""
        photon = rays.photon
        if doubtful.any():
            self.doubtful[photon[doubtful]] = True
        number = np.take(self._number, end)
        if self._first:
            self._home[photon], self._first, at = number, False, slice(None)
        else:
            home = np.take(self._home, photon)
            at = np.flatnonzero((number != home) | (home < 0) | np.take(self._away, photon))
            self._away[photon[at[np.take(end, at) >= self._solid]]] = True
        start = rays.start[:, at] - self._centre
        far = np.minimum(distance[at], 2 * self._extent + np.sqrt(dot(start, start)))
        stop = start + far * rays.direction[:, at]
        self._parts.append((photon[at].astype(np.int32), start.astype(np.float32), stop.astype(np.float32)))

    def take(self):
        """photon (k,), start and stop (3,k), about the middle of the tracer, of all that was added."""
        return tuple(np.concatenate(part, axis=-1) for part in zip(*self._parts, strict=True))


def crossing(start, stop, low, high, extent):
    """Whether (k,) segments from start to stop (3,k) float32 come into any of the boxes low, high (n,3), by which
    they are no more than `extent` off."""
    found = np.zeros(start.shape[1], bool)
    far = _MARGIN * extent + _FAR * np.abs(start).max(initial=0)
    low, high = (low - far).astype(np.float32)[:, :, None], (high + far).astype(np.float32)[:, :, None]
    for k in range(0, len(found), _BLOCK):
        s, e = start[:, k : k + _BLOCK], stop[:, k : k + _BLOCK]
        least, most = np.minimum(s, e), np.maximum(s, e)
        for near, beyond in zip(low, high, strict=True):
            at = np.flatnonzero(_all(least <= beyond) & _all(most >= near))
            found[k + at[_pierces(s[:, at], e[:, at], near, beyond)]] = True
    return found


def _pierces(start, stop, low, high):
    """Whether (k,) segments (3,k) come into a box low, high (3,1)."""
    along = stop - start
    along[np.abs(along) < _STRAIGHT] = _STRAIGHT
    a, b = (low - start) / along, (high - start) / along
    enters, leaves = np.minimum(a, b), np.maximum(a, b)
    first = np.maximum(np.maximum(enters[0], enters[1]), np.maximum(enters[2], 0))
    return first <= np.minimum(np.minimum(leaves[0], leaves[1]), np.minimum(leaves[2], 1))


def _all(flags):
    """Whether all three rows of flags (3,k) hold: rows by rows is quicker than numpy's own."""
    return flags[0] & flags[1] & flags[2]
