"""Waters that tests share: strips, parts of a grid, single triangles, and changes that must not matter."""

from dataclasses import replace

import numpy as np
from waves import mesh_water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.scene import Water


def strip(profile, normals, width=12.0, rows=2):
    """Water of a profile (n,2) in x and z, with normals (n,2), `width` along y in so many rows of vertices."""
    n = len(profile)
    y = np.repeat(np.linspace(-width / 2, width / 2, rows), n)
    x, z = np.tile(profile, (rows, 1)).T
    up = np.tile(np.column_stack([normals[:, 0], np.zeros(n), normals[:, 1]]), (rows, 1))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    i = (np.arange(n - 1) + n * np.arange(rows - 1)[:, None]).ravel()
    triangles = np.concatenate([np.stack([i, i + 1, i + 1 + n], 1), np.stack([i, i + 1 + n, i + n], 1)])
    return mesh_water(np.stack([x, y, z], 1), triangles, up)


def curl(lean, count=121, rows=2, width=12.0):
    """Waves of 1.6 m whose crests lean over by `lean` m, `count` vertices along: from 0.25 m they overhang."""
    k = 2 * np.pi / 1.6
    s = np.linspace(-width / 2, width / 2, count)
    profile = np.stack([s + lean * np.cos(k * s), 1.5 + 0.08 * np.sin(k * s)], 1)
    return strip(profile, np.stack([-0.08 * k * np.cos(k * s), 1 - lean * k * np.sin(k * s)], 1), width, rows)


def droplets():
    """Nine closed droplets of eight triangles each, 0.3 m above the pool's water."""
    tips = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    places = [(x, y, 1.8) for x in (-1, 0, 1) for y in (-1, 0, 1)]
    return [mesh_water(np.array(place) + 0.05 * tips, triangles, tips) for place in places]


def with_triangles(water, triangles):
    """The same vertices and normals under other triangles."""
    return mesh_water(water.positions, triangles, water.normals)


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
