"""What even spreading leaves where many beams meet: each lays its light a little beside where it comes, and in a focus
they all do so to the same side.

The image of a beam is that of a quadratic map through its six rays; spread over the triangle of its corners, its light
lies off by the mean of what lies between, a third of the sum of how far the middles of its edges are from the chords'.
Flux F that is moved by d goes over the border of two texels if it lies on it, F d / w of it if it is w wide. So much is
summed on each border, before the light that comes to a texel over all of its borders is squared: in a focus within one
texel, light goes over all four outwards. `prediction.predict` has what is left of a beam on its own, and the same
measure of how much of it stays within a beam that is wide.
"""

from __future__ import annotations

import numpy as np

_TINY = np.finfo(float).tiny


class Drift:
    """On square maps of resolution^2 texels each, one for each of `images`."""

    def __init__(self, images, resolution):
        self._side = resolution
        self._across = np.zeros((2, images * resolution * (resolution + 1)))  # borders of columns, and of rows

    def add(self, image, x, y, flux):
        """Add beams on images (n,) whose six rays land at x, y (6,n) [texel], of flux (n,) over a texel's area."""
        off = [sum(v[3 + k] - (v[k] + v[(k + 1) % 3]) / 2 for k in range(3)) / 3 for v in (x, y)]
        (x1, x2), (y1, y2) = x[1:3] - x[0], y[1:3] - y[0]
        long = np.maximum(np.maximum(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2), (x2 - x1) ** 2 + (y2 - y1) ** 2)
        long = np.sqrt(np.maximum(long, 1.0))
        wide = np.maximum(np.abs(x1 * y2 - x2 * y1) / long, 1.0)
        far = np.maximum(np.hypot(*off), _TINY)
        weight = flux * np.minimum(far, wide) / (far * np.sqrt(long * wide**3))
        middle = [v[:3].mean(0) + d / 2 for v, d in zip((x, y), off, strict=True)]
        spans = [np.ptp(v[:3], axis=0) for v in (x, y)]
        for axis, (across, d, span) in enumerate(zip(self._across, off, spans, strict=True)):
            along = np.clip(middle[1 - axis], 0, self._side - 1).astype(np.int64)
            border = np.clip(np.rint(middle[axis]), 0, self._side)
            span = np.clip(np.maximum(span, np.abs(d)), _TINY, 1.0)
            on = np.flatnonzero(np.abs(middle[axis] - border) <= span / 2)
            cell = (image * self._side + along)[on] * (self._side + 1) + border[on].astype(np.int64)
            across += np.bincount(cell, (weight * d / span)[on], len(across))

    def error(self):
        """Sum of squared errors over all texels, of flux over a texel's area squared."""
        x, y = (np.diff(across.reshape(-1, self._side, self._side + 1)) for across in self._across)
        return float(((x + y.swapaxes(1, 2)) ** 2).sum())
