"""Casters and rooms in closed form, shared by the tests of light over glass and mirrors."""

from dataclasses import replace

import numpy as np
from waves import quad

from dapple.kernels.casters import Caster, Glass, Mirror
from dapple.kernels.scene import Water

GLASS = Glass(1.5)
SILVER = Mirror(np.ones(3), np.ones(3))


def no_water():
    """The Water of a scene that has none."""
    none, index = np.zeros((0, 3)), np.zeros((0, 3), int)
    return Water("None", none, index, none, index, np.zeros(0, int))


def patch(point, normal, u, v, material=GLASS, name="Patch"):
    """A smooth-shaded Caster of point(u, v) (3,...) over a grid of parameters, with normals normal(u, v)."""
    grid_u, grid_v = np.meshgrid(u, v, indexing="ij")
    positions, normals = (np.stack(f(grid_u, grid_v), -1).reshape(-1, 3) for f in (point, normal))
    i = np.arange(grid_u.size).reshape(grid_u.shape)
    corner = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)
    triangles = corner[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    v0, v1, v2 = (positions[triangles[:, k]] for k in range(3))
    across = np.cross(v1 - v0, v2 - v0)
    sound = np.linalg.norm(across, axis=1) > 1e-12
    against = (across * normals[triangles].sum(1)).sum(1) < 0
    triangles[against] = triangles[against][:, ::-1]
    triangles = triangles[sound]
    return Caster(name, positions, triangles, normals, triangles, material)


def ball(radius=1.0, centre=(0.0, 0.0, 0.0), fine=64, material=GLASS, name="Ball"):
    """A sphere of 2 fine by fine facets."""

    def normal(u, v):
        return np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)

    def point(u, v):
        return tuple(c + radius * n for c, n in zip(centre, normal(u, v), strict=True))

    return patch(
        point, normal, np.linspace(0, 2 * np.pi, 2 * fine + 1), np.linspace(0, np.pi, fine + 1), material, name
    )


def faceted(positions, faces, material=GLASS, name="Solid"):
    """A flat-shaded convex solid of faces, tuples of indices into positions (n,3); its normals point outwards."""
    positions = np.asarray(positions, float)
    triangles = np.array([[f[0], f[k], f[k + 1]] for f in faces for k in range(1, len(f) - 1)])
    v = positions[triangles]
    normals = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    inward = (normals * (v.mean(1) - positions.mean(0))).sum(1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    normals = np.where(inward[:, None], -normals, normals)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(normals))[:, None], 3, 1)
    return Caster(name, positions, triangles, normals, rows, material)


def prism(apex, side=1.0, length=4.0, material=GLASS):
    """A prism along y whose edge of angle `apex` is on top; its sides are `side` long."""
    x, z = side * np.sin(apex / 2), side * np.cos(apex / 2)
    section = np.array([[0, 0], [-x, -z], [x, -z]])
    ends = [np.insert(section, 1, y, axis=1) for y in (-length / 2, length / 2)]
    faces = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]
    return faceted(np.concatenate(ends), faces, material)


_CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def slab(low, high, material=GLASS, name="Slab"):
    """A block of glass from `low` to `high`."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    return faceted((low + high) / 2 + _CORNERS * (high - low) / 2, _FACES, material, name)


def inside_out(mesh):
    """The same surface with its normals to the other side."""
    shading = mesh.normal_triangles[:, ::-1]
    return replace(mesh, normals=-mesh.normals, triangles=mesh.triangles[:, ::-1], normal_triangles=shading)


def joined(*casters):
    """One mesh of several, of the material of the first."""
    starts = np.cumsum([0, *(len(c.positions) for c in casters)])
    shading = np.cumsum([0, *(len(c.normals) for c in casters)])
    return Caster(
        "Joined",
        np.concatenate([c.positions for c in casters]),
        np.concatenate([c.triangles + n for c, n in zip(casters, starts, strict=False)]),
        np.concatenate([c.normals for c in casters]),
        np.concatenate([c.normal_triangles + n for c, n in zip(casters, shading, strict=False)]),
        casters[0].material,
    )


def room(half=1.0):
    """Receivers on all six sides of a cube, their normals inwards."""
    return tuple(quad(f"Side {k}", half * _CORNERS[list(face)]) for k, face in enumerate(_FACES))
