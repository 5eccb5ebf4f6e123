"""Meshes of a Pond's waves, as an artist or a simulation would have them: Blender's own normals, on any lattice."""

from __future__ import annotations

import numpy as np
from waves import grid, mesh_water

QUADS = 128  # along a side: 32,768 triangles
NOISE = 2e-4  # m
_NONE = 1e9  # far from every point


def exact(pond, quads=QUADS):
    """A regular grid with the waves' own normals."""
    x, y = _plan(pond, quads)
    height, slope_x, slope_y = pond.waves(x, y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return mesh_water(np.stack([x, y, pond.depth + height], 1), grid(quads, 1.0)[2], normals)


def regular(pond, quads=QUADS, noise=0.0):
    """A regular grid; noise: standard deviation [m] of the heights."""
    x, y = _plan(pond, quads)
    height = pond.waves(x, y)[0] + noise * np.random.default_rng(7).standard_normal(len(x))
    corner = grid(quads, 1.0)[2].reshape(-1, 6)[:, [0, 1, 2, 5]]
    return blender(np.stack([x, y, pond.depth + height], 1), corner)


def jittered(pond, quads=QUADS):
    """A grid whose inner vertices are moved by up to 0.25 of its spacing, in triangles."""
    x, y = _plan(pond, quads)
    inner = np.zeros((quads + 1, quads + 1), bool)
    inner[1:-1, 1:-1] = True
    shift = np.random.default_rng(8).uniform(-0.25, 0.25, (2, len(x))) * pond.side / quads * inner.ravel()
    x, y = x + shift[0], y + shift[1]
    return blender(np.stack([x, y, pond.depth + pond.waves(x, y)[0]], 1), grid(quads, 1.0)[2])


def blue_noise(pond, quads=QUADS):
    """Delaunay triangles of points that keep a distance, as many as the grid has or a few less."""
    from mathutils.geometry import delaunay_2d_cdt

    points = _spaced(quads)
    faces = delaunay_2d_cdt([tuple(map(float, p)) for p in points], [], [], 0, 1e-9)[2]
    x, y = (pond.bounds[0] + points * pond.side).T
    return blender(np.stack([x, y, pond.depth + pond.waves(x, y)[0]], 1), np.array(faces))


def iso_surface(pond, cells=61):
    """Marching tetrahedra on a lattice of cubes: its crossings lie on the waves, and its triangles have all shapes."""
    edge = pond.side / cells
    layers = int(np.ceil(2 * pond.waves.amplitude.sum() / edge)) + 1
    shape = np.array([cells + 1, cells + 1, layers + 1])
    low = np.array([*pond.bounds[0], pond.depth - layers * edge / 2 - 0.37 * edge])
    lattice = low + edge * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1).reshape(-1, 3)
    above = lattice[:, 2] - pond.depth > pond.waves(lattice[:, 0], lattice[:, 1])[0]
    ends, triangles = _march(above, shape)
    a, b = lattice[ends[:, 0]], lattice[ends[:, 1]]
    inside, outside = np.zeros(len(a)), np.ones(len(a))
    for _ in range(40):
        middle = (inside + outside) / 2
        p = a + middle[:, None] * (b - a)
        same = (p[:, 2] - pond.depth > pond.waves(p[:, 0], p[:, 1])[0]) == above[ends[:, 0]]
        inside, outside = np.where(same, middle, inside), np.where(same, outside, middle)
    p = a + inside[:, None] * (b - a)
    normal = np.cross(p[triangles[:, 1]] - p[triangles[:, 0]], p[triangles[:, 2]] - p[triangles[:, 0]])
    triangles[normal[:, 2] < 0] = triangles[normal[:, 2] < 0][:, ::-1]
    return blender(p, triangles)


def blender(positions, faces):
    """Smooth-shaded Water with the normals and triangles that Blender makes of positions (V,3) and faces (F,3 or 4)."""
    import bpy

    mesh = bpy.data.meshes.new("Water")
    mesh.from_pydata(positions.tolist(), [], faces.tolist())
    mesh.shade_smooth()
    mesh.calc_loop_triangles()
    kept, normals = np.empty((2, len(mesh.vertices), 3), np.float32)
    triangles = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.vertices.foreach_get("co", kept.reshape(-1))
    mesh.vertex_normals.foreach_get("vector", normals.reshape(-1))
    mesh.loop_triangles.foreach_get("vertices", triangles.reshape(-1))
    bpy.data.meshes.remove(mesh)
    normals = normals.astype(float)
    return mesh_water(kept.astype(float), triangles, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _plan(pond, quads):
    x, y, _ = grid(quads, pond.side)
    return x + pond.centre[0], y + pond.centre[1]


def _spaced(quads, rounds=40):
    """Points of the unit square, regular on its border, no two nearer than 0.83 of the grid's spacing: in every round
    each empty cell of a fine lattice draws a point, and keeps it if none that came first is near."""
    rng = np.random.default_rng(9)
    least = 0.83 / quads
    count = int(np.ceil(np.sqrt(2) / least))
    axis = np.arange(quads) / quads
    border = np.concatenate([[axis, 0 * axis], [1 + 0 * axis, axis], [1 - axis, 1 + 0 * axis], [0 * axis, 1 - axis]], 1)
    border = border.reshape(4, 2, -1).transpose(1, 0, 2).reshape(2, -1)
    kept = np.full((2, count + 4, count + 4), _NONE)
    column, row = np.meshgrid(np.arange(count), np.arange(count))
    from_border = 0.5 * least
    for _ in range(rounds):
        drawn = np.full_like(kept, -_NONE)
        drawn[:, 2:-2, 2:-2] = (np.stack([column, row]) + rng.uniform(size=(2, count, count))) / count
        off = (kept[0] < _NONE) | (np.abs(drawn - 0.5).max(0) > 0.5 - from_border)
        rank = rng.uniform(size=off.shape)
        rank[off] = np.inf
        free = ~off
        for i in range(-2, 3):
            for j in range(-2, 3):
                near_kept, near, other = (np.roll(v, (i, j), (-2, -1)) for v in (kept, drawn, rank))
                free &= ~(((near_kept - drawn) ** 2).sum(0) < least**2)
                free &= ~((((near - drawn) ** 2).sum(0) < least**2) & (other < rank))
        kept[:, free] = drawn[:, free]
    return np.concatenate([border, kept[:, kept[0] < _NONE]], 1).T


def _march(above, shape):
    """Crossed edges (E,2) of lattice points, and triangles (T,3) of them, wound either way."""
    number = np.arange(shape.prod()).reshape(shape)
    cube = [number[i : i - 1 or None, j : j - 1 or None, k : k - 1 or None].ravel() for i in (0, 1) for j in (0, 1)
            for k in (0, 1)]  # fmt: skip
    paths = ((1, 3), (1, 5), (2, 3), (2, 6), (4, 5), (4, 6))
    tetrahedra = np.concatenate([np.stack([cube[0], cube[a], cube[b], cube[7]], 1) for a, b in paths])
    order = np.argsort(above[tetrahedra], axis=1, kind="stable")
    tetrahedra = np.take_along_axis(tetrahedra, order, 1)
    count = above[tetrahedra].sum(1)
    corners = {1: [(3, 0), (3, 1), (3, 2)], 3: [(0, 1), (0, 2), (0, 3)]}
    pieces = [tetrahedra[count == n][:, pairs] for n, pairs in corners.items()]
    two = tetrahedra[count == 2]
    pieces += [two[:, [(0, 2), (0, 3), (1, 3)]], two[:, [(0, 2), (1, 3), (1, 2)]]]
    edges = np.sort(np.concatenate(pieces).reshape(-1, 2), axis=1)
    ends, index = np.unique(edges, axis=0, return_inverse=True)
    return ends, index.reshape(-1, 3)
