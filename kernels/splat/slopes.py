"""How steep water is, and over how much of itself it lies: what tells which light can meet it again."""

from __future__ import annotations

import numpy as np

from ..halfedges import AFTER
from ..maps.coverage import edge_coverage
from ..maps.uv_raster import cross2

_GRID = 128  # cells along each side of the plan in which sheets of water are counted


def steepness(direction):
    """Least rise over run of directions (3,k), below 0 for those that go down."""
    run = np.sqrt(direction[0] ** 2 + direction[1] ** 2)
    return (direction[2] / np.maximum(run, np.finfo(float).tiny)).min(initial=np.inf)


def squared_slopes(across):
    """Squared slopes (T,) of triangles, by vectors across (3,T) them: inf for those that do not look up."""
    x, y, z = across
    run = x * x + y * y
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = run / (z * z)
    squared[z <= 0] = np.inf
    squared[(z == 0) & (run == 0)] = 0  # no triangle at all
    return squared


def slopes_round(corners, normals):
    """Squared slope (n,) of the steepest edge or normal of triangles with corners and normals there (n,3,3)."""
    steepest = np.zeros(len(corners))
    for k in range(3):
        x, y, z = (corners[:, k] - corners[:, k - 1]).T
        with np.errstate(over="ignore"):
            edge = z * z / np.maximum(x * x + y * y, np.finfo(float).tiny)
        steepest = np.maximum(np.maximum(steepest, edge), squared_slopes(normals[:, k].T))
    return steepest


def sheets(positions, triangles, twins):
    """How many sheets of water that looks up lie over each other, at most, in the mean over a cell of the plan.

    Its borders alone tell, since what triangles have in common cancels.
    """
    rim = np.flatnonzero(twins < 0)
    if not len(rim):
        return 0.0
    plan = positions[:, :2]
    start, end = plan[triangles[rim // 3, rim % 3]], plan[triangles[rim // 3, AFTER[rim % 3]]]
    low = start.min(0)
    cell = np.maximum((start.max(0) - low) / _GRID, np.finfo(float).tiny)
    v0, v1, v2 = (plan[triangles[rim // 3, k]] for k in range(3))
    wound = np.sign(cross2(v1 - v0, v2 - v0))
    covered = edge_coverage(((start - low) / cell).T, ((end - low) / cell).T, wound[None], (_GRID, _GRID))
    return float(covered.max())
