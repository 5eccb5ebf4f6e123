"""Planes among what a scene is made of: where rays meet them is told in closed form, without a ray being cast.

A flat part is all triangles of a mesh in one plane, if they fill a convex outline of few sides and are alike in all
that is asked of what a ray meets: then one of them stands for all.
"""

from __future__ import annotations

import numpy as np

from ..halfedges import build_twins
from ..rays import MISS
from ..scene import Receiver

_PARTS, _SIDES = 3, 8  # of a mesh, and of an outline, at most: else a ray is as cheap
_OFF = 1e-7  # of the extent, and of a map: what single precision leaves of a plane, and of an affine map
_ALIKE = 1e-9  # normals


class Flats:
    """parts: a list of (triangle, rows (1 + sides, 4)): the number that stands for one, its plane and the planes across
    it of its outline's sides, unit normals and offsets, which look inwards."""

    def __init__(self, parts):
        self._planes = np.array([rows[0] for _, rows in parts]).reshape(-1, 4)
        self._parts = [(triangle, rows[1:, :3].copy(), rows[1:, 3:].copy()) for triangle, rows in parts]

    def first(self, origin, direction):
        """The triangle (k,) that rays (3,k) would meet first if there were only flat parts, MISS for none, and how far
        it is (k,)."""
        end, far = np.full(origin.shape[1], MISS, np.int32), np.full(origin.shape[1], np.inf)
        normals, offsets = self._planes[:, :3], self._planes[:, 3:]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # rays along a plane
            distances = (normals @ origin + offsets) / -(normals @ direction)
            for distance, (triangle, across, held) in zip(distances, self._parts, strict=True):
                met = (distance > 0) & (distance < far)
                point = distance * direction
                point += origin
                met &= (across @ point + held >= 0).all(0)
                np.copyto(far, distance, where=met)
                np.copyto(end, triangle, where=met)
        return end, far


def parts(mesh, base):
    """The parts of a mesh for `Flats`, its triangles being numbered from base; None unless all of it is flat."""
    if not len(mesh.triangles):
        return []
    v, found = mesh.positions[mesh.triangles], []
    across = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    size, extent = np.linalg.norm(across, axis=1), np.linalg.norm(np.ptp(v, axis=(0, 1)))
    left = np.ones(len(v), bool)
    while left.any():
        largest = int(np.argmax(np.where(left, size, -1.0)))
        if len(found) == _PARTS or size[largest] == 0:
            return None
        normal = across[largest] / size[largest]
        plane = np.array([*normal, -normal @ v[largest, 0]])
        own = left & (np.abs(v @ normal + plane[3]) <= _OFF * extent).all(1) & (across @ normal > 0)
        sides = _sides(v[own], mesh.triangles[own], normal, extent) if _uniform(mesh, own, largest) else None
        if sides is None:
            return None
        found.append((base + largest, np.concatenate([plane[None], sides])))
        left &= ~own
    return found


def _sides(v, triangles, normal, extent):
    """Rows (sides, 4) of the outline of triangles v (T,3,3) in a plane, None if it is not convex or has too many."""
    rim = np.flatnonzero(build_twins(triangles) < 0)
    start, stop = v.reshape(-1, 3)[rim], v.reshape(-1, 3)[rim - rim % 3 + (rim + 1) % 3]
    inward = np.cross(normal, stop - start)
    inward /= np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), np.finfo(float).tiny)
    _, some = np.unique(np.round(inward, 6), axis=0, return_index=True)
    rows = np.concatenate([inward, -(inward * start).sum(1, keepdims=True)], 1)[some]
    if len(some) > _SIDES or not len(some):
        return None
    inner = v.reshape(-1, 3) @ rows[:, :3].T + rows[:, 3] >= -_OFF * extent
    return rows if inner.all() else None


def _uniform(mesh, own, largest):
    """Whether triangles own (T,) of a mesh are alike: of one affine map without a seam, or shaded by one normal."""
    if isinstance(mesh, Receiver):
        return _one_map(mesh, own, largest)
    if not hasattr(mesh, "normals"):
        return True
    normals = mesh.normals[mesh.normal_triangles[own]]
    return bool((np.abs(normals - mesh.normals[mesh.normal_triangles[largest, 0]]) <= _ALIKE).all())


def _one_map(receiver, own, largest):
    """As `_uniform`, of a Receiver."""
    v, uv = receiver.positions[receiver.triangles], receiver.uvs
    known = np.zeros((len(receiver.positions), 2))
    known[receiver.triangles[own]] = uv[own]
    if (known[receiver.triangles[own]] != uv[own]).any():
        return False
    edges = np.stack([v[largest, 1] - v[largest, 0], v[largest, 2] - v[largest, 0]], 1)
    weights = np.linalg.lstsq(edges, (v[own] - v[largest, 0]).reshape(-1, 3).T, rcond=None)[0].T
    image = uv[largest, 0] + weights @ (uv[largest, 1:] - uv[largest, 0])
    return bool((np.abs(image - uv[own].reshape(-1, 2)) <= _OFF).all())
