"""Where water is a height field: sheets of it, each connected and nowhere near steep faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_STEEP = 0.25  # least |n_z| of a face, as a cosine, for its height to be a good coordinate
_RINGS = 2  # of vertices round steep faces that are left out
_DROPLET = 0.02  # of the water's area in plan: smaller pieces are no sheets


@dataclass(frozen=True)
class Sheets:
    """number (V,): the sheet that each vertex is on, -1 for none; support (V,): the same, with the vertices between a
    sheet and the steep faces, which are on none but known to belong to its surface; count of sheets."""

    number: np.ndarray
    support: np.ndarray
    count: int


def find_sheets(positions, triangles):
    """The Sheets of a mesh: positions (V,3), triangles (T,3). Faces that look up and down never share one."""
    count = len(positions)
    plan, whole = _face_normals(positions, triangles)
    steep = ~(np.abs(plan) >= _STEEP * whole)
    up, down, touching = np.zeros((3, count), bool)
    up[triangles[plan > 0]] = down[triangles[plan < 0]] = touching[triangles[steep]] = True
    touching |= up & down
    far = touching.copy()
    for _ in range(_RINGS if far.any() else 0):
        far[triangles[far[triangles].any(1)]] = True
    sound = triangles[~(steep | (up & down)[triangles].any(1))]
    label = components(sound, count)
    area = np.bincount(label[triangles[:, 0]], np.abs(plan), minlength=count)
    large = np.flatnonzero(area > _DROPLET * np.abs(plan).sum())
    rank = np.full(count, -1)
    rank[large] = np.arange(len(large))
    used = np.zeros(count, bool)
    used[sound] = True
    sheet = np.where(used, rank[label], -1)
    return Sheets(np.where(far, -1, sheet), np.where(touching, -1, sheet), len(large))


def components(triangles, count):
    """For each of `count` vertices the least vertex that triangles (T,3) connect it with."""
    label = np.arange(count)
    a, b = triangles[:, [0, 1]].T.ravel(), triangles[:, [1, 2]].T.ravel()
    while len(a):
        one, other = label[a], label[b]
        apart = one != other
        a, b, one, other = a[apart], b[apart], one[apart], other[apart]
        np.minimum.at(label, np.maximum(one, other), np.minimum(one, other))
        while True:
            shorter = label[label]
            if np.array_equal(shorter, label):
                break
            label = shorter
    return label


def _face_normals(positions, triangles):
    """z (T,) of the faces' normals and their length (T,): twice the area in plan, with sign, and in space."""
    v = [np.take(positions.T, triangles[:, k], axis=1) for k in range(3)]
    e, f = v[1] - v[0], v[2] - v[0]
    x, y, z = e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]
    return z, np.sqrt(x * x + y * y + z * z)
