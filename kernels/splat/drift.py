"""What even spreading leaves where many beams meet: each lays its light a little beside where it comes, and in a focus
they all do so to the same side.

The image of a beam is that of a quadratic map through its six rays; spread over the triangle of its corners, its light
lies off by the mean of what lies between, a third of the sum of how far the middles of its edges are from the chords'.
Flux F that is moved by d changes the light by - div (F d), which is summed before it is squared. `prediction.predict`
has what is left of a beam on its own, and the same measure of how much of it stays within a beam that is wide.
"""

from __future__ import annotations

import numpy as np


class Drift:
    """On square maps of resolution^2 texels each, one for each of `images`."""

    def __init__(self, images, resolution):
        self._shape = images, resolution, resolution
        self._moved = np.zeros((2, images * resolution**2))

    def add(self, image, x, y, flux):
        """Add beams on images (n,) whose six rays land at x, y (6,n) [texel], of flux (n,) over a texel's area."""
        off = [sum(v[3 + k] - (v[k] + v[(k + 1) % 3]) / 2 for k in range(3)) / 3 for v in (x, y)]
        (x1, x2), (y1, y2) = x[1:3] - x[0], y[1:3] - y[0]
        long = np.maximum(np.maximum(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2), (x2 - x1) ** 2 + (y2 - y1) ** 2)
        long = np.sqrt(np.maximum(long, 1.0))
        wide = np.maximum(np.abs(x1 * y2 - x2 * y1) / long, 1.0)
        far = np.maximum(np.hypot(*off), np.finfo(float).tiny)
        weight = flux * np.minimum(far, wide) / (far * np.sqrt(long * wide**3))
        side = self._shape[1]
        i, j = (np.clip(v[:3].mean(0), 0, side - 1).astype(np.int64) for v in (x, y))
        cell = (image * side + j) * side + i
        for moved, d in zip(self._moved, off, strict=True):
            moved += np.bincount(cell, weight * d, len(moved))

    def error(self):
        """Sum of squared errors over all texels, of flux over a texel's area squared."""
        x, y = (np.pad(moved.reshape(self._shape), ((0, 0), (1, 1), (1, 1))) for moved in self._moved)
        away = (x[:, 1:-1, 2:] - x[:, 1:-1, :-2] + y[:, 2:, 1:-1] - y[:, :-2, 1:-1]) / 2
        return float((away**2).sum())
