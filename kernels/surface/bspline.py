"""Uniform bicubic B-splines over a rectangle: values and slopes at scattered points, and the transpose of that.

A Lattice of (rows, columns) cells has (rows + 3, columns + 3) coefficients. In the cell of a point 4 x 4 of them count,
weighted by products of the four pieces of the cubic B-spline along each axis [1].

[1] de Boor 1978, A Practical Guide to Splines, chapters IX to XI.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

_BLOCK = 8192  # points at once: what is known of them stays in the cache


@dataclass(frozen=True)
class Lattice:
    """low (2,) [m] corner of the rectangle; step (2,) [m] of its cells along x, y; cells (rows, columns)."""

    low: np.ndarray
    step: np.ndarray
    cells: tuple[int, int]

    @property
    def shape(self):
        """(rows, columns) of the coefficients."""
        return self.cells[0] + 3, self.cells[1] + 3

    def locate(self, x, y):
        """Flat index (n,) of the first of the 4 x 4 coefficients that count at points x, y (n,), and the points'
        coordinates u, v (n,) in their cells, 0..1. Points outside continue the cells along the border."""
        u, v = (x - self.low[0]) / self.step[0], (y - self.low[1]) / self.step[1]
        i = np.clip(u, 0, self.cells[1] - 1).astype(np.int64)
        j = np.clip(v, 0, self.cells[0] - 1).astype(np.int64)
        return j * self.shape[1] + i, u - i, v - j

    def halved(self):
        """The Lattice of twice as many cells along each axis."""
        return Lattice(self.low, self.step / 2, (2 * self.cells[0], 2 * self.cells[1]))


class Samples:
    """Points x, y (n,) on a Lattice: the matrix B of a spline's values there, and its transpose."""

    def __init__(self, lattice, x, y):
        first, u, v = lattice.locate(x, y)
        wx, wy = pieces(u), pieces(v)
        self.shape = lattice.shape
        self._index = (first + _offsets(lattice)).ravel()
        self._weight = (wy[:, None] * wx).reshape(16, -1)

    def values(self, c):
        """B c (n,) of coefficients c (rows, columns)."""
        return np.einsum("kn,kn->n", self._weight, np.take(c, self._index).reshape(self._weight.shape))

    def spread(self, z):
        """B^T z (rows, columns) of numbers z (n,)."""
        return self._sum(self._weight * z)

    @cached_property
    def diagonal(self):
        """Diagonal (rows, columns) of B^T B."""
        return self._sum(self._weight**2)

    def _sum(self, terms):
        count = self.shape[0] * self.shape[1]
        return np.bincount(self._index, terms.ravel(), minlength=count).reshape(self.shape)


def evaluate(lattice, c, x, y):
    """Value and slopes along x and y, (3,n), at points x, y (n,) of the spline with coefficients c."""
    out = np.empty((3, len(x)))
    offsets = _offsets(lattice)
    for k in range(0, len(x), _BLOCK):
        first, u, v = lattice.locate(x[k : k + _BLOCK], y[k : k + _BLOCK])
        near = np.take(c, first + offsets).reshape(4, 4, -1)
        along, steep = (np.einsum("jin,in->jn", near, w) for w in (pieces(u), slopes(u)))
        wy = pieces(v)
        block = out[:, k : k + _BLOCK]
        block[0] = np.einsum("jn,jn->n", along, wy)
        block[1] = np.einsum("jn,jn->n", steep, wy) / lattice.step[0]
        block[2] = np.einsum("jn,jn->n", along, slopes(v)) / lattice.step[1]
    return out


def pieces(u):
    """The four pieces (4,n) of the cubic B-spline at u (n,) in 0..1."""
    t = 1 - u
    uu, tt = u * u, t * t
    return np.stack([tt * t, 4 - 3 * uu * (1 + t), 4 - 3 * tt * (1 + u), uu * u]) / 6


def slopes(u):
    """The derivatives (4,n) of the four pieces at u (n,)."""
    t = 1 - u
    return np.stack([-t * t, u * (3 * u - 4), t * (4 - 3 * t), u * u]) / 2


def insert_knots(c):
    """Coefficients (2r + 3, 2q + 3), on the halved Lattice, of the spline with coefficients c (r + 3, q + 3)."""
    for _ in range(2):
        fine = np.empty((2 * len(c) - 3, c.shape[1]))
        fine[0::2] = (c[:-1] + c[1:]) / 2
        fine[1::2] = (c[:-2] + 6 * c[1:-1] + c[2:]) / 8
        c = fine.T
    return c


def _offsets(lattice):
    """Steps (16,1) in the flat index from the first of 4 x 4 coefficients to each."""
    step = np.arange(4)
    return (step[:, None] * lattice.shape[1] + step).reshape(16, 1)
