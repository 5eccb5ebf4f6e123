"""Meshes of one water as they come: regular, jittered, blue noise, iso-surfaces; with normals as Blender makes them."""

import numpy as np
from waves import grid, jittered_grid, shaded_smooth

ISO_CELLS = 0.62  # cells of the iso-surface's grid per quad of the others: about as many vertices


def make(kind, shape, quads, side, level, noise=0.0, seed=0):
    """Water of one kind on `shape(x, y)`: about quads^2 vertices, heights off by `noise` [m]."""
    rng = np.random.default_rng(seed)
    if kind in ("iso-surface", "interpolated iso-surface"):
        positions, triangles = _iso_surface(shape, round(quads * ISO_CELLS), side, kind == "iso-surface")
    else:
        x, y, triangles = {"regular": grid, "jittered": jittered_grid, "blue noise": _blue_noise}[kind](quads, side)
        positions = np.stack([x, y, shape(x, y)[0]], 1)
    positions[:, 2] += level + noise * rng.standard_normal(len(positions))
    return shaded_smooth(positions.astype(np.float32).astype(float), triangles)  # in the digits that Blender has


def _blue_noise(quads, side):
    """Points no nearer to each other than 0.8 of a cell, thrown until few gaps are left, and their Delaunay mesh."""
    from matplotlib.tri import Triangulation

    near = 0.8 * side / quads
    cell = near / np.sqrt(2)
    width = int(side / cell) + 3
    edge = np.linspace(-side / 2, side / 2, quads + 1)
    low, high = np.full_like(edge, -side / 2), np.full_like(edge, side / 2)
    rim = np.concatenate([np.stack(p, 1) for p in ((edge, low), (edge, high), (low, edge), (high, edge))])
    points, grid_of = [], {}
    for p in (*np.unique(rim, axis=0), *np.random.default_rng(2).uniform(-side / 2, side / 2, (18 * quads**2, 2))):
        i, j = ((p + side / 2) / cell).astype(int)
        around = [grid_of.get((i + a) * width + j + b) for a in range(-2, 3) for b in range(-2, 3)]
        on_rim = len(points) < 4 * quads
        if on_rim or all(q is None or (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 >= near**2 for q in around):
            grid_of[i * width + j] = p
            points.append(p)
    x, y = np.array(points).T
    triangles = Triangulation(x, y).triangles.astype(np.int64)
    u, v = ([c[triangles[:, k]] - c[triangles[:, 0]] for c in (x, y)] for k in (1, 2))
    area = u[0] * v[1] - u[1] * v[0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return x, y, triangles[np.abs(area) > 1e-9]


_TETRAHEDRA = ([0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7])


def _iso_surface(shape, cells, side, exact):
    """Marching tetrahedra over z - shape(x, y): vertices on the water, or where linear interpolation has them."""
    step = side / cells
    layers = int(np.ceil(0.2 / step)) + 3
    axis = -side / 2 + np.arange(cells + 1) * step
    x, y, z = np.meshgrid(axis, axis, (np.arange(layers + 1) - layers / 2 + 0.137) * step, indexing="ij")
    value = (z - shape(x, y)[0]).ravel()
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], 1)
    index = np.arange(len(nodes)).reshape(x.shape)
    corner = [index[a : a + cells, b : b + cells, c : c + layers] for c in (0, 1) for b in (0, 1) for a in (0, 1)]
    corner = np.stack([c.ravel() for c in corner], 1)
    tets = np.concatenate([corner[:, t] for t in _TETRAHEDRA])
    edges = _crossed(tets, value)
    key = edges.min(2) * len(nodes) + edges.max(2)
    known, triangles = np.unique(key, return_inverse=True)
    a, b = nodes[known // len(nodes)], nodes[known % len(nodes)]
    fa, fb = value[known // len(nodes)], value[known % len(nodes)]
    share = (fa / (fa - fb))[:, None]
    if exact:
        share = _roots(shape, a, b, fa)
    positions, triangles = a + share * (b - a), triangles.reshape(-1, 3)
    v = positions[triangles]
    down = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])[:, 2] < 0
    triangles[down] = triangles[down][:, ::-1]
    return positions, triangles


def _crossed(tets, value):
    """Per triangle (n,3,2) the edges of the tetrahedra that it cuts."""
    above = value[tets] > 0
    out = []
    for side, count in ((True, 1), (False, 3)):
        some = tets[above.sum(1) == count]
        alone = (above[above.sum(1) == count] == side).argmax(1)
        others = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[alone]
        one = np.take_along_axis(some, alone[:, None], 1)
        out.append(np.stack([np.broadcast_to(one, others.shape), np.take_along_axis(some, others, 1)], 2))
    two = above.sum(1) == 2
    a, b, c, d = np.take_along_axis(tets[two], np.argsort(~above[two], axis=1, kind="stable"), 1).T
    for corners in (((a, c), (a, d), (b, d)), ((a, c), (b, d), (b, c))):
        out.append(np.stack([np.stack(edge, 1) for edge in corners], 1))
    return np.concatenate(out)


def _roots(shape, a, b, start):
    """Shares (n,1) at which the edges from a to b (n,3) meet the water, by bisection."""
    low, high = np.zeros(len(a)), np.ones(len(a))
    for _ in range(40):
        middle = (low + high) / 2
        p = a + middle[:, None] * (b - a)
        same = (p[:, 2] > shape(p[:, 0], p[:, 1])[0]) == (start > 0)
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return ((low + high) / 2)[:, None]
