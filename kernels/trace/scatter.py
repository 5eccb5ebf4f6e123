"""Points with footprints: light that no beams follow, landed by strata of points, each as wide as they lie apart.

A point's neighbours are those of the strata beside it whose light went the same way to the same chart. Its flux is
spread over the parallelogram that reaches half of the way to each of them, so that all of it lies between places where
light was seen to land. Where there is none on a side, it reaches no further; points closer than a texel need no width.
Where texels are finer than a lone point can tell, it lies on a square that is as wide as it speaks for, in its chart.
Points of even and of odd strata make a picture each, and their difference tells the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..splat.sheet import Sheet

_STEPS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F], np.uint64)  # odd: keys of strata beside each other
_SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
_MIX = np.uint64(0xD6E8FEB86659FD93)


@dataclass
class Points:
    """Where points landed: key (k,) uint64 from `keys`; even (k,) bool, of which half; chart (k,), x, y (k,) [texel];
    flux (C,k); wide (k,) [texel]: of a lone one."""

    key: np.ndarray
    even: np.ndarray
    chart: np.ndarray
    x: np.ndarray
    y: np.ndarray
    flux: np.ndarray
    wide: np.ndarray


def keys(stratum, *way):
    """A number (k,) for strata (2,k) of points and their ways, arrays (k,) of integers: those of strata beside it on
    an axis, with the same way, are _STEPS away."""
    mixed = np.zeros(stratum.shape[1], np.uint64)
    for part in way:
        mixed ^= np.ascontiguousarray(part, np.int64).view(np.uint64)
        mixed ^= mixed >> np.uint64(32)
        mixed *= _MIX
    return mixed + (stratum.astype(np.uint64) * _STEPS[:, None]).sum(0, dtype=np.uint64)


class Scatter:
    """Takes points, and lands them; image (charts,) and images, resolution, channels as of a `Sheet`; box (2,2,charts)
    [texel]: the least and the most x and y of each chart."""

    def __init__(self, image, images, resolution, channels, box):
        self._box = box
        self._halves = [Sheet(image, images, resolution, channels) for _ in range(2)]
        self._parts = []

    def add(self, points):
        self._parts.append(points)

    def take(self):
        """Flux (C, texels) of all points, of the even ones less the odd ones, and all (C,) that was left, what lies
        beyond the images' rims included."""
        if self._parts:
            parts, self._parts = self._parts, []
            columns = zip(*(vars(part).values() for part in parts), strict=True)
            self._land(Points(*(np.concatenate(column, axis=-1) for column in columns)))
        even, odd = (half.flux() for half in self._halves)
        return even + odd, even - odd, sum(half.landed for half in self._halves)

    def _land(self, points):
        """Leave Points on the sheets."""
        x, y = self._corners(points)
        wide = np.maximum(np.ptp(x, axis=0), np.ptp(y, axis=0)) >= 1
        for sheet, half in zip(self._halves, (points.even, ~points.even), strict=True):
            at = np.flatnonzero(half & ~wide)
            sheet.add_points(points.chart[at], points.x[at], points.y[at], points.flux[:, at])
            at = np.flatnonzero(half & wide)
            sheet.add_parallelograms(points.chart[at], x[:, at], y[:, at], points.flux[:, at])

    def _corners(self, points):
        """Corners x, y (4,k), one after the other, of what Points are spread over."""
        corners, lone = _between(points)
        at = np.flatnonzero(lone & (points.wide >= 1))
        if len(at):
            low, high = np.take(self._box, points.chart[at], axis=2)
            half = np.minimum(points.wide[at], high - low) / 2
            middle = np.clip(np.stack([points.x[at], points.y[at]]), low + half, high - half)
            corners[:, :, at] = middle + half * _SQUARE[:, :, None]
        return corners[:, 0], corners[:, 1]


def _between(points):
    """Corners (4,2,k), one after the other, of what lies between Points and their neighbours; whether (k,) they have
    none."""
    order = np.argsort(points.key)
    known = points.key[order]
    low, high = np.zeros((2, 2, len(known))), np.zeros((2, 2, len(known)))  # axis of the strata, x or y
    place = np.stack([points.x, points.y])
    for axis, step in enumerate(_STEPS):
        beside = known + step
        found = np.minimum(np.searchsorted(known, beside), max(len(known) - 1, 0))
        met = np.flatnonzero(known[found] == beside)
        mine, next_one = order[met], order[found[met]]
        half = (place[:, next_one] - place[:, mine]) / 2
        high[axis][:, mine], low[axis][:, next_one] = half, -half
    (a, b), (c, d) = (low[0], high[0]), (low[1], high[1])
    lone = ~np.stack([a, b, c, d]).any((0, 1))
    return place + np.stack([a + c, b + c, b + d, a + d]), lone
