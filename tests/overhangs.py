"""Waves that overhang, in closed form, and their meshes: shared by tests and benchmarks."""

import numpy as np
from waves import grid, shaded_smooth

from dapple.kernels.scene import Water
from dapple.kernels.surface.tessellate import Tessellation


class Breaking:
    """A crest sheared sideways by `lean` until it overhangs: x = u + lean z, z = crest exp(-(u/wide)^2) + a ripple."""

    def __init__(self, lean=1.6, crest=0.4, wide=0.35):
        self.lean, self.crest, self.wide = lean, crest, wide

    def points(self, u, y):
        z = self._height(u, y)[0]
        return np.stack([u + self.lean * z, y, z], 1)

    def normals(self, points, _):
        """Exact unit normals (n,3) at points (n,3), which may lie a little off it."""
        _, along, across = self._height(points[:, 0] - self.lean * points[:, 2], points[:, 1])
        n = np.stack([-along, -across, 1 + self.lean * along], 1)
        return n / np.linalg.norm(n, axis=1, keepdims=True)

    def _height(self, u, y):
        hump = self.crest * np.exp(-((u / self.wide) ** 2))
        return hump + 0.02 * np.sin(5 * y), -2 * u / self.wide**2 * hump, 0.1 * np.cos(5 * y)


class Trochoid:
    """Waves of `length` m whose crests lean over past their cusps: x = s + lean cos ks, z = height sin ks."""

    def __init__(self, lean=0.3, height=0.08, length=1.6):
        self.lean, self.height, self.k = lean, height, 2 * np.pi / length

    def points(self, s, y):
        return np.stack([s + self.lean * np.cos(self.k * s), y, self.height * np.sin(self.k * s)], 1)

    def normals(self, points, s):
        """Exact unit normals (n,3) at the places of the wave nearest to points (n,3), by steps from s (n,) on: past
        their cusps trochoids cross themselves."""
        for _ in range(8):  # Gauss and Newton's
            off = (points - self.points(s, points[:, 1]))[:, [0, 2]]
            tangent = np.stack(self._tangent(s), 1)
            s = s + (off * tangent).sum(1) / (tangent**2).sum(1)
        along, up = self._tangent(s)
        n = np.stack([-up, 0 * s, along], 1)
        return n / np.linalg.norm(n, axis=1, keepdims=True)

    def _tangent(self, s):
        return 1 - self.lean * self.k * np.sin(self.k * s), self.height * self.k * np.cos(self.k * s)


def meshed(wave, quads, side=4.0):
    """Smooth-shaded Water of an overhanging wave."""
    x, y, triangles = grid(quads, side)
    return shaded_smooth(wave.points(x, y), triangles)


def parameters(quads, side, k):
    """What the vertices of k x k parts of the triangles of `meshed` are made from, along the waves: (n,)."""
    x, y, triangles = grid(quads, side)
    return straight(shaded_smooth(np.stack([x, y, 0 * x], 1), triangles), k).positions[:, 0]


def straight(mesh, k):
    """The mesh as it is, in k x k parts."""
    parts = Tessellation(mesh.triangles, mesh.twins, len(mesh.positions), np.ones(len(mesh.triangles), bool), k)
    points = []
    for values in (mesh.positions, mesh.normals):
        new = [np.einsum("cnd,cm->nmd", values[e], s) for e, s in zip((parts.ends, parts.inner), parts.shares())]
        points.append(np.concatenate([values, *(v.reshape(-1, 3) for v in new)]))
    return Water(mesh.name, points[0], parts.triangles, points[1], parts.triangles, parts.twins)


def angles(water, exact):
    """Angles (n,) between the normals of a Water and exact ones (n,3)."""
    n = water.normals / np.linalg.norm(water.normals, axis=1, keepdims=True)
    return 2 * np.arcsin(np.minimum(np.linalg.norm(n - exact, axis=1) / 2, 1))
