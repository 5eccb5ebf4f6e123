"""Sheets of the water that are height fields: over the plan, and where it is steep or overhangs over upright planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_STEEP = 0.25  # least |cosine| between a face's normal and the axis of heights
_RINGS = 10  # of vertices round steep faces that are left out: a height field that ends at an upright tangent is no
# spline, and the error runs in from there (5 leave a third of a mesh's own error on trochoids, 10 and 15 a twentieth)
_LEAST = {2: 0.02, 0: 0.002, 1: 0.002}  # of the water's area, across the axis of heights: less is a droplet
_FEW = 50  # vertices: an upright sheet has more


@dataclass(frozen=True)
class Sheet:
    """axis: 0, 1, 2, the coordinate that is the height; support (n,): vertices that the surface passes through; on (V,)
    bool: those of them that are far enough from where it is steep; distance [m]: typical of neighbours in support,
    across the heights, as on a square grid of as many vertices; faces (T,) bool: all corners are in support."""

    axis: int
    support: np.ndarray
    on: np.ndarray
    distance: float
    faces: np.ndarray


def turned(vectors, axis):
    """Vectors (3, ...) with the coordinate `axis` last, by a rotation."""
    return np.roll(vectors, 2 - axis, axis=0)


def turned_back(vectors, axis):
    """The inverse of `turned`."""
    return np.roll(vectors, axis - 2, axis=0)


def find_sheets(positions, triangles, body=None):
    """The Sheets of a mesh: positions (V,3), triangles (T,3), and its `components` (V,), if known. Those over the plan
    come first; upright ones only where the mesh has faces on none of these."""
    normals = _face_normals(positions, triangles)
    area = np.sqrt((normals**2).sum(0))
    sheets, rest = [], np.ones(len(triangles), bool)
    body = components(triangles, len(positions)) if body is None else body
    for axis in (2, 0, 1):
        steep = ~(np.abs(normals[axis]) >= _STEEP * area)
        needles = np.flatnonzero(steep)
        needles = needles[_gentle(turned(positions.T, axis), triangles[needles])]
        steep[needles] = False
        height = normals[axis].copy()
        height[needles] = 0
        for sheet in _along(axis, height, steep, area, triangles, body, rest):
            sheets.append(sheet)
            rest &= ~sheet.on[triangles].all(1)
        if not rest.any():
            break
    return sheets


def _along(axis, height, steep, area, triangles, body, rest):
    """The Sheets with heights along an axis that hold faces of `rest` (T,), by the faces' normals along it (T,) and
    whether they are steep. Faces that look up and down never share one."""
    count = len(body)
    up, down, touching = np.zeros((3, count), bool)
    up[triangles[height > 0]] = down[triangles[height < 0]] = touching[triangles[steep]] = True
    both = up & down
    touching |= both
    far = touching.copy()
    for _ in range(_RINGS if far.any() else 0):
        far[triangles[far[triangles].any(1)]] = True
    faces = np.flatnonzero(~(steep | both[triangles].any(1)))
    label = body if len(faces) == len(triangles) else components(triangles[faces], count)
    of_face = label[triangles[faces, 0]]
    size = np.bincount(of_face, np.abs(height[faces]), minlength=count)
    wanted = np.bincount(of_face, rest[faces], minlength=count) > 0
    for one in np.flatnonzero(wanted & (size > _LEAST[axis] * area.sum())):
        inside = np.zeros(len(triangles), bool)
        inside[faces[of_face == one]] = True
        used = np.zeros(count, bool)
        used[triangles[inside]] = True
        used &= ~touching
        inside &= used[triangles].all(1)
        support = np.flatnonzero(used)
        if inside.any() and (axis == 2 or len(support) > _FEW):
            distance = np.sqrt(np.abs(height[inside]).sum() / 2 / len(support))
            yield Sheet(axis, support, used & ~far, distance, inside)


def _gentle(points, triangles):
    """Whether no edge of triangles (n,3) rises more than it runs, heights last in points (3,V): then a steep normal is
    only that of a needle, whose corners lie in a row in plan."""
    gentle = np.ones(len(triangles), bool)
    for k in range(3):
        run = points[:, triangles[:, k]] - points[:, triangles[:, k - 1]]
        gentle &= run[2] ** 2 <= run[0] ** 2 + run[1] ** 2
    return gentle


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
    """Normals (3,T) of the faces, by their winding, twice their area long."""
    v = [np.take(positions.T, triangles[:, k], axis=1) for k in range(3)]
    e, f = v[1] - v[0], v[2] - v[0]
    return np.stack([e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]])
