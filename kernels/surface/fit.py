"""A smooth height field through scattered points: one cubic B-spline lattice by penalised least squares.

    minimise  |B c - z|^2 + lambda (|c_xxx|^2 + 3 |c_xxy|^2 + 3 |c_xyy|^2 + |c_yyy|^2)

with third differences of the coefficients c in the penalty [1], which planes and paraboloids do not pay. The normal
equations are solved by conjugate gradients with Jacobi's preconditioner, on cells of twice the size first.

[1] Eilers, Currie & Durban 2006, Fast and compact smoothing on large multidimensional grids.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bspline import Lattice, Samples, evaluate, insert_knots

CELL = 0.75  # of the typical distance of vertices
_PENALTY = (1.0, 3.0, 3.0, 1.0)  # weights of third differences, of which 0, 1, 2, 3 are along y
_COARSER = 16  # times less penalty on cells of twice the size: differences grow 8 times, nodes are 4 times fewer
_TOLERANCE = 1e-2, 5e-6  # residual of the normal equations, relative to their right side: coarse and fine
_SHOWS = 6e-4  # residuals r leave 3000 r^2 of error in the light at most, seen on five waters: a thousandth then
_MOST = 500  # steps


@dataclass(frozen=True)
class HeightField:
    """A spline over a Lattice with coefficients c (rows, columns), added to the plane z = plane . (1, x, y)."""

    lattice: Lattice
    c: np.ndarray
    plane: np.ndarray

    def at(self, x, y):
        """z and its slopes along x and y, (3,n), at points x, y (n,)."""
        out = evaluate(self.lattice, self.c, x, y)
        out += np.stack([self.plane[0] + self.plane[1] * x + self.plane[2] * y, *self.plane[1:, None] + 0 * x])
        return out


def fit(points, distance, smoothing, tolerance=_TOLERANCE, sampled=Samples):
    """The HeightField nearest to points (n,3).

    distance [m]: typical distance of neighbouring points in plan; smoothing: lambda, in points per cell; tolerance:
    residuals of the normal equations, relative to their right side, coarse and fine; sampled: makes the Samples.
    """
    x, y, _ = points.T
    rest, plane = detrended(points)
    lattice = coarse_lattice(points[:, :2], distance)
    penalty = smoothing * len(rest) / (4 * lattice.cells[0] * lattice.cells[1])
    c = np.zeros(lattice.shape)
    c = solve(sampled(lattice, x, y), rest, penalty / _COARSER, c, tolerance[0])
    lattice = lattice.halved()
    return HeightField(lattice, solve(sampled(lattice, x, y), rest, penalty, insert_knots(c), tolerance[1]), plane)


def fit_tolerance(error):
    """The residuals for `fit` that leave about a thousandth of a relative mean squared error of the light."""
    return _TOLERANCE[0], max(float(_SHOWS * np.sqrt(error)), _TOLERANCE[1])


def detrended(points):
    """Heights (n,) of points (n,3) over their plane of least squares, and that plane (3,): z = plane . (1, x, y)."""
    basis = np.stack([np.ones(len(points)), points[:, 0], points[:, 1]], 1)
    plane, *_ = np.linalg.lstsq(basis, points[:, 2], rcond=None)
    return points[:, 2] - basis @ plane, plane


def coarse_lattice(points, distance):
    """The Lattice over the box of points (n,2) whose halved cells are about CELL distances wide."""
    low, high = points.min(0), points.max(0)
    extent = np.maximum(high - low, distance)
    cells = np.maximum(np.ceil(extent / (2 * CELL * distance)).astype(int), 1)
    return Lattice(low, extent / cells, (int(cells[1]), int(cells[0])))


def solve(samples, z, penalty, c, tolerance):
    """Coefficients (rows, columns) for heights z (n,) at Samples, by conjugate gradients from c on."""
    diagonal = samples.diagonal + penalty * _roughness_diagonal(samples.shape)
    diagonal[diagonal == 0] = 1  # coefficients that nothing asks for
    right = samples.spread(z)
    goal = tolerance**2 * (right**2).sum()
    residual = right - samples.spread(samples.values(c)) - penalty * _roughness(c)
    scaled = residual / diagonal
    c, along, rho = c.copy(), scaled.copy(), (residual * scaled).sum()
    for _ in range(_MOST):
        if (residual**2).sum() <= goal:
            break
        image = samples.spread(samples.values(along)) + penalty * _roughness(along)
        step = rho / (along * image).sum()
        c += step * along
        residual -= step * image
        scaled = residual / diagonal
        rho, before = (residual * scaled).sum(), rho
        along *= rho / before
        along += scaled
    return c


def _roughness(c):
    """Half the gradient (rows, columns) of the penalty by c (rows, columns)."""
    down = [c]
    for _ in range(3):
        down.append(down[-1][1:] - down[-1][:-1])
    out = _PENALTY[3] * down[3]
    for k in (2, 1, 0):
        along = down[k]
        for _ in range(3 - k):
            along = along[:, 1:] - along[:, :-1]
        for _ in range(3 - k):
            along = _transposed_difference(along.T).T
        out = _transposed_difference(out)
        out += _PENALTY[k] * along
    return out


def _transposed_difference(steps):
    """Transpose of the first difference along the rows: one row more, in the memory's order of `steps`."""
    out = np.empty_like(steps, shape=(len(steps) + 1, steps.shape[1]))
    np.negative(steps[:1], out=out[:1])
    np.subtract(steps[:-1], steps[1:], out=out[1:-1])
    out[-1:] = steps[-1:]
    return out


def _roughness_diagonal(shape):
    """Diagonal (rows, columns) of the penalty's matrix."""
    squares = [np.array([1.0])]
    for order in (1, 2, 3):
        stencil = np.array([1.0])
        for _ in range(order):
            stencil = np.convolve(stencil, [-1.0, 1.0])
        squares.append(stencil**2)

    def line(count, order):
        return np.convolve(np.ones(count - order), squares[order])

    return sum(w * line(shape[0], k)[:, None] * line(shape[1], 3 - k) for k, w in enumerate(_PENALTY))
