"""One tile of water repeated in two directions, as one mesh without seams."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import build_twins
from ..scene import Water

_FIT = 1e-4  # of a period: how far borders that are to meet may lie apart
_RIM = (
    "the water does not tile: {:.0%} of the vertices at its rim have none like them at the other side; its opposite "
    "sides must have the same shape, as far apart as those of the receiver"
)


@dataclass(frozen=True)
class Lattice:
    """origin (3,) of a tile and its sides (2,3) [m], horizontal: what is at P is at P + i side 0 + j side 1 too."""

    origin: np.ndarray
    sides: np.ndarray

    def coordinates(self, positions):
        """Where positions (n,3) lie along the sides, in tiles: (n,2), the tile itself in 0..1."""
        return (positions - self.origin)[:, :2] @ np.linalg.inv(self.sides[:, :2])


def repeated(water, lattice, low, high):
    """A Water, one tile, repeated as far as it takes to cover low to high (2,) of the lattice's coordinates.

    What is off by more than a cell is left out. Raises ValueError for water whose sides do not fit each other.
    """
    vertex, shift = _welds(water, lattice)
    own = lattice.coordinates(water.positions)
    first = np.floor(low - own.max(0)).astype(int)
    last = np.ceil(high - own.min(0)).astype(int)
    steps = np.stack(np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last)), indexing="ij"), -1).reshape(-1, 2)
    corners = own[water.triangles]
    parts = [_in_reach(corners + step, low, high) for step in steps]
    kept = [(step, np.flatnonzero(part)) for step, part in zip(steps, parts) if part.any()]
    cell = np.concatenate([vertex[water.triangles[part]].ravel() for _, part in kept])
    at = np.concatenate([(shift[water.triangles[part]] + step).reshape(-1, 2) for step, part in kept])
    _, one, index = np.unique(np.column_stack([at, cell]), axis=0, return_index=True, return_inverse=True)
    positions = water.positions[cell[one]] + at[one] @ lattice.sides
    triangles = index.reshape(-1, 3).astype(np.int32)
    smooth = water.normal_triangles is water.triangles
    if smooth:
        normals, shaded = _joined(water.normals, vertex)[cell[one]], triangles
    else:
        normals, shaded = water.normals, np.concatenate([water.normal_triangles[part] for _, part in kept])
    return Water(water.name, positions, triangles, normals, shaded, build_twins(triangles))


def _in_reach(corners, low, high):
    """Which triangles, corners (T,3,2) in the lattice, have a part in low to high."""
    return ((corners.max(1) >= low) & (corners.min(1) <= high)).all(1)


def _welds(water, lattice):
    """For each vertex the one that it is the same as (V,), and by how many tiles (V,2) further on."""
    count = len(water.positions)
    vertex, shift = np.arange(count), np.zeros((count, 2), int)
    half = np.flatnonzero(water.twins < 0)
    rim = np.unique(np.concatenate([water.triangles.ravel()[half], np.roll(water.triangles, -1, 1).ravel()[half]]))
    found = np.zeros(count, bool)
    for k in range(2):
        here, there = _pairs(water.positions, rim, lattice.sides[k])
        vertex[there] = here
        shift[there] = np.eye(2, dtype=int)[k]
        found[here] = found[there] = True
    if not len(rim) or not found[rim].all():
        raise ValueError(_RIM.format(1 - found[rim].mean() if len(rim) else 1.0))
    # A corner goes back along both sides.
    return vertex[vertex], shift + shift[vertex]


def _pairs(positions, rim, side):
    """Vertices at the rim (n,) and those (n,) that lie one side further on."""
    width = _FIT * np.linalg.norm(side)
    ahead = np.argsort(positions[rim] @ side, kind="stable")
    along = (positions[rim] @ side)[ahead]
    target = positions[rim] + side
    start = np.searchsorted(along, target @ side - width * np.linalg.norm(side))
    end = np.searchsorted(along, target @ side + width * np.linalg.norm(side))
    here, there = [], []
    for vertex, a, b, wanted in zip(rim, start, end, target):
        near = rim[ahead[a:b]]
        distance = np.abs(positions[near] - wanted).max(1) if len(near) else np.array([])
        if len(near) and distance.min() <= width:
            here.append(vertex)
            there.append(near[distance.argmin()])
    return np.array(here, int), np.array(there, int)


def _joined(normals, vertex):
    """Unit normals (V,3) of a tile, with those of vertices that are one summed: each knows its own side only."""
    total = np.zeros_like(normals)
    np.add.at(total, vertex, normals)
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), np.finfo(float).tiny)
    return total[vertex]
