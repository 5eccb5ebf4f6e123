"""Meshes of casters in closed form: ball, ring, box, cut stone, trough."""

from __future__ import annotations

import numpy as np

from dapple.kernels.casters import Caster


def caster(name, surface, material, at=(0, 0, 0), flat=False):
    """A Caster of a surface (positions, normals, triangles) moved by `at`; flat: shaded by its facets."""
    positions, normals, triangles = surface
    index = triangles
    if flat:
        corners = positions[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        index = np.repeat(np.arange(len(triangles))[:, None], 3, 1)
    return Caster(name, positions + np.asarray(at, float), triangles, normals, index, material)


def sheet(function, u, v, wrap=(False, False)):
    """Positions (V,3) and triangles (T,3) of function(u, v) -> (...,3) on a grid of the axes u and v; where it wraps,
    the axis does not repeat its first value."""
    rows, columns = len(u), len(v)
    positions = function(*np.meshgrid(u, v, indexing="ij")).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rows - (not wrap[0])), np.arange(columns - (not wrap[1])), indexing="ij")
    a, b = i * columns + j, (i + 1) % rows * columns + j
    c, d = (i + 1) % rows * columns + (j + 1) % columns, i * columns + (j + 1) % columns
    return positions, np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)


def ball(radius=1.0, parts=128):
    """A sphere: a cube's six grids pushed outwards, so that no triangle is a sliver."""
    axis = np.tan(np.linspace(-1, 1, parts // 4 + 1) * np.pi / 4)
    positions, triangles, base = [], [], 0
    for k in range(3):
        for sign in (1, -1):

            def face(u, v, k=k, sign=sign):
                point = np.empty((*u.shape, 3))
                point[..., k], point[..., (k + 1) % 3], point[..., (k + 2) % 3] = sign, sign * u, v
                return point

            p, t = sheet(face, axis, axis)
            positions.append(p)
            triangles.append(t + base)
            base += len(p)
    positions = np.concatenate(positions)
    normals = positions / np.linalg.norm(positions, axis=1, keepdims=True)
    unique, inverse = np.unique(np.round(normals, 9), axis=0, return_inverse=True)
    normals = unique / np.linalg.norm(unique, axis=1, keepdims=True)
    return radius * normals, normals, inverse.reshape(-1)[np.concatenate(triangles)]


def ring(major, minor, parts=(256, 96)):
    """A torus that lies flat: radius `major` of its circle, `minor` of its tube."""
    u, v = (np.arange(n) * 2 * np.pi / n for n in parts)

    def surface(u, v, tube=minor, circle=major):
        rho = circle + tube * np.cos(v)
        return np.stack([rho * np.cos(u), rho * np.sin(u), tube * np.sin(v)], -1)

    positions, triangles = sheet(surface, u, v, (True, True))
    normals = surface(*np.meshgrid(u, v, indexing="ij"), 1.0, 0.0).reshape(-1, 3)
    return positions, normals, triangles


def box(size, turn=0.0):
    """A box of a size (3,), turned about z by `turn` [rad]; no normals, it is for facets."""
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    turned = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return signs * np.asarray(size) / 2 @ turned.T, None, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def stone(radius, sides=8):
    """A cut stone: a table, a crown of kites' outlines, a pavilion that ends in a point; facets, convex."""
    angle = np.arange(sides) * 2 * np.pi / sides
    rims = [(0.53, 0.16, 0.0), (1.0, 0.0, np.pi / sides)]  # of the table and the girdle: radius, height, turn
    points = [np.stack([r * np.cos(angle + t), r * np.sin(angle + t), np.full(sides, z)], 1) for r, z, t in rims]
    points = np.concatenate([*points, [[0, 0, 0.16], [0, 0, -0.43]]])
    triangles, top, tip = [], 2 * sides, 2 * sides + 1
    for i in range(sides):
        j = (i + 1) % sides
        triangles += [[top, i, j], [i, sides + i, j], [j, sides + i, sides + j], [sides + i, tip, sides + j]]
    return radius * points, None, np.array(triangles)


def trough(radius, height, half_angle=np.pi / 2, parts=(256, 8)):
    """Part of an upright circular cylinder about the z axis, open towards -x, its normals inwards."""
    u, v = np.linspace(-half_angle, half_angle, parts[0] + 1), np.linspace(0, height, parts[1] + 1)
    positions, triangles = sheet(lambda u, v: np.stack([radius * np.cos(u), radius * np.sin(u), v], -1), u, v)
    normals = positions * [-1, -1, 0] / radius
    return positions, normals, triangles[:, ::-1]
