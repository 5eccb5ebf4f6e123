"""Waters and pools in closed form, shared by the tests, the benchmarks and the figures."""

import numpy as np

from dapple.kernels.halfedges import build_twins
from dapple.kernels.scene import Receiver, Scene, Sun, Water

AMPLITUDE = np.array([0.020, 0.012, 0.010, 0.006, 0.004])  # m
WAVELENGTH = np.array([1.6, 0.9, 0.62, 0.37, 0.23])  # m
HEADING = np.radians([20, 75, -40, 130, -100])
PHASE = np.array([0, 1.3, 2.1, 0.7, 4.0])
OBLIQUE = (0.25, 0.1, -1.0)


def five_sines(x, y, scale=1.0):
    """Height [m] and slopes of the pool's waves at t = 0, amplitudes times `scale`."""
    k = 2 * np.pi / WAVELENGTH
    phase = k * (x[..., None] * np.cos(HEADING) + y[..., None] * np.sin(HEADING)) + PHASE
    slope = scale * AMPLITUDE * k * np.cos(phase)
    return (
        (scale * AMPLITUDE * np.sin(phase)).sum(-1),
        (slope * np.cos(HEADING)).sum(-1),
        (slope * np.sin(HEADING)).sum(-1),
    )


def flat(x, y):
    """Still water."""
    return np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)


def grid(quads, side):
    """x, y of a square grid round the origin, and its triangles."""
    axis = np.linspace(-side / 2, side / 2, quads + 1)
    x, y = np.meshgrid(axis, axis)
    i = np.arange(quads * (quads + 1)).reshape(quads, quads + 1)[:, :-1].ravel()
    corner = np.stack([i, i + 1, i + quads + 2, i + quads + 1], 1)
    return x.ravel(), y.ravel(), corner[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def mesh_water(positions, triangles, normals):
    """Smooth-shaded Water of arrays."""
    return Water("Water", positions, triangles, normals, triangles, build_twins(triangles))


def faceted(water):
    """The same mesh, shaded flat."""
    v = water.positions[water.triangles]
    normals = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(normals))[:, None], 3, 1)
    return Water(water.name, water.positions, water.triangles, normals, rows, water.twins)


def shaded_smooth(positions, triangles):
    """Smooth-shaded Water as Blender has it: the normals are the facets' means by corner angle."""
    v = positions[triangles]
    facet = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    facet /= np.maximum(np.linalg.norm(facet, axis=1, keepdims=True), 1e-300)
    normals = np.zeros_like(positions)
    for k in range(3):
        a, b = v[:, (k + 1) % 3] - v[:, k], v[:, (k + 2) % 3] - v[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1))
        np.add.at(normals, triangles[:, k], angle[:, None] * facet)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return mesh_water(positions, triangles, normals)


def jittered_grid(quads, side, seed=1):
    """A grid as of `grid` whose inner vertices are moved by up to 0.3 of a cell along x and y."""
    x, y, triangles = grid(quads, side)
    inner = np.maximum(np.abs(x), np.abs(y)) < side / 2 - 1e-9
    dx, dy = np.random.default_rng(seed).uniform(-0.3, 0.3, (2, len(x))) * inner * side / quads
    return x + dx, y + dy, triangles


def water(shape=five_sines, quads=64, side=4.8, level=1.5):
    """Water over a grid with heights and slopes of `shape(x, y)` and exact normals."""
    x, y, triangles = grid(quads, side)
    height, slope_x, slope_y = shape(x, y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return mesh_water(np.stack([x, y, level + height], 1), triangles, normals)


def quad(name, corners, uv_low=(0.0, 0.0), uv_high=(1.0, 1.0)):
    """A planar Receiver of four corners (4,3), in a rectangle of the UV square."""
    triangles = np.array([[0, 1, 2], [0, 2, 3]])
    unit = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    uv = np.add(uv_low, unit * np.subtract(uv_high, uv_low))
    return Receiver(name, np.asarray(corners, float), triangles, uv[triangles])


def turned(receiver):
    """The same Receiver with its front where its back was."""
    return Receiver(receiver.name, receiver.positions, receiver.triangles[:, ::-1], receiver.uvs[:, ::-1])


def floor(side=4.0, z=0.0, **uv):
    """A square floor round the origin."""
    half = side / 2
    return quad("Floor", [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]], **uv)


def sun(direction=OBLIQUE, irradiance=(1.0, 1.0, 1.0)):
    """A Sun whose light travels along `direction`."""
    direction = np.asarray(direction, float)
    return Sun("Sun", direction / np.linalg.norm(direction), np.asarray(irradiance, float))


def pool(shape=five_sines, quads=64, direction=OBLIQUE, receivers=None, occluders=(), side=4.8, eta=1.333):
    """The pool: water over a floor of 4 x 4 m, 1.5 m deep."""
    receivers = (floor(),) if receivers is None else tuple(receivers)
    return Scene(water(shape, quads, side), receivers, tuple(occluders), (sun(direction),), eta)


def calm(x, y):
    """Waves so low for the depth that one path leads to every point."""
    return five_sines(x, y, 0.12)


def transmitted(cos_i, eta=1.333):
    """Fresnel transmittance of unpolarised light, in the textbook's angles."""
    i = np.arccos(cos_i)
    if i == 0:
        return 1 - ((eta - 1) / (eta + 1)) ** 2
    t = np.arcsin(np.sin(i) / eta)
    r_s = np.sin(i - t) / np.sin(i + t)
    r_p = np.tan(i - t) / np.tan(i + t)
    return 1 - (r_s**2 + r_p**2) / 2
