"""Waters that tests share: strips, parts of a grid, single triangles, and changes that must not matter."""

from dataclasses import replace

import numpy as np
from waves import mesh_water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.scene import Water


def strip(profile, normals, width=12.0):
    """Water of a profile (n,2) in x and z, wound so that it is lit from above, with normals (n,2), `width` along y."""
    n = len(profile)
    ends = [np.column_stack([profile[:, 0], np.full(n, y), profile[:, 1]]) for y in (-width / 2, width / 2)]
    up = np.column_stack([normals[:, 0], np.zeros(n), normals[:, 1]])
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    i = np.arange(n - 1)
    triangles = np.concatenate([np.stack([i, i + 1, i + 1 + n], 1), np.stack([i, i + 1 + n, i + n], 1)])
    return mesh_water(np.concatenate(ends), triangles, np.concatenate([up, up]))


def with_triangles(water, triangles):
    """The same vertices and normals under other triangles."""
    return mesh_water(water.positions, triangles, water.normals)


def faceted(water):
    """The same mesh, shaded flat."""
    v = water.positions[water.triangles]
    normals = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(normals))[:, None], 3, 1)
    return Water(water.name, water.positions, water.triangles, normals, rows, water.twins)


def joined(*waters):
    """Several waters as one, no vertex shared."""
    starts = np.cumsum([0, *(len(w.positions) for w in waters)])
    triangles = np.concatenate([w.triangles + s for w, s in zip(waters, starts, strict=False)])
    positions, normals = (np.concatenate([getattr(w, k) for w in waters]) for k in ("positions", "normals"))
    return Water(waters[0].name, positions, triangles, normals, triangles, build_twins(triangles))


def moved(scene, change):
    """The scene with change(positions (V,3)) in the place of all positions."""

    def each(things):
        return tuple(replace(thing, positions=change(thing.positions)) for thing in things)

    water = replace(scene.water, positions=change(scene.water.positions))
    return replace(scene, water=water, receivers=each(scene.receivers), occluders=each(scene.occluders))
