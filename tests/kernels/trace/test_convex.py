"""Which meshes are convex but for shallow dents, and that light which leaves those outwards never meets them again."""

from dataclasses import replace

import numpy as np
import pytest
from bench import caster_shapes as shapes
from casters import GLASS, faceted, inside_out, joined, patch, prism, slab

from dapple.kernels.casters import Caster
from dapple.kernels.rays import MISS, Tracer
from dapple.kernels.trace.convex import dents
from dapple.kernels.trace.surfaces import _geometry


def ball(parts=32):
    """A cube's grids pushed out to a sphere: half of their quads are split along the wrong diagonal."""
    return shapes.caster("Ball", shapes.ball(1.0, parts), GLASS, (3, -2, 1))


def stone():
    return shapes.caster("Stone", shapes.stone(0.12), GLASS, flat=True)


def moved(mesh, seed, noise=0.0):
    """The mesh turned and stretched, with what single precision takes from its coordinates."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag([1, 1.4, 0.8])
    turn *= np.sign(np.linalg.det(turn))
    positions = mesh.positions @ turn.T
    positions = positions.astype(np.float32).astype(float) if noise else positions
    normals = mesh.normals @ np.linalg.inv(turn)
    return replace(mesh, positions=positions, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True))


def sines(mesh):
    return dents(mesh.positions, mesh.triangles, _geometry(mesh)[:3])


def globe(rows=24, columns=48):
    """A sphere of rings: its quads are flat but for rounding."""
    v, u = np.linspace(0, np.pi, rows + 1)[1:-1], np.arange(columns) * 2 * np.pi / columns
    ring = np.stack(np.broadcast_arrays(np.sin(v)[:, None] * np.cos(u), np.sin(v)[:, None] * np.sin(u)), -1)
    rim = np.concatenate([ring, np.broadcast_to(np.cos(v)[:, None, None], (*ring.shape[:2], 1))], -1).reshape(-1, 3)
    positions = np.concatenate([rim, [[0, 0, 1], [0, 0, -1]]])
    at = np.arange(len(rim)).reshape(rows - 1, columns)
    a, b, c, d = at[:-1], np.roll(at[:-1], -1, 1), np.roll(at[1:], -1, 1), at[1:]
    top, low = np.full(columns, len(rim)), np.full(columns, len(rim) + 1)
    parts = [(a, d, c), (a, c, b), (top, at[0], np.roll(at[0], -1)), (low, np.roll(at[-1], -1), at[-1])]
    triangles = np.concatenate([np.stack(part, -1).reshape(-1, 3) for part in parts])
    return Caster("Globe", positions, triangles, positions, triangles, GLASS)


@pytest.mark.parametrize("make", [ball, globe, stone, lambda: slab((-1, -2, 0), (1, 2, 0.3)), lambda: prism(0.9)])
@pytest.mark.parametrize("noise", [0.0, 1.0], ids=["double", "single"])
def test_what_leaves_outwards_never_comes_back(make, noise):
    """From every facet to all sides, by more than the sine that is told: no ray meets the mesh again."""
    mesh, rng = moved(make(), 1, noise), np.random.default_rng(2)
    sine = sines(mesh)
    facet, tracer = _geometry(mesh)[:3], Tracer(mesh.positions, mesh.triangles)
    at = np.tile(np.arange(len(sine)), max(20000 // len(sine), 8))
    weights = rng.dirichlet([0.5] * 3, len(at))  # many near the edges
    point = (mesh.positions[mesh.triangles[at]] * weights[:, :, None]).sum(1)
    normal, least = facet.T[at], np.maximum(sine[at], 1e-4)
    cosine = least + (1 - least) * rng.random(len(at)) ** 4  # many that graze
    side = np.cross(normal, rng.normal(size=(len(at), 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    direction = cosine[:, None] * normal + np.sqrt(1 - cosine**2)[:, None] * side
    off = 2e-6 * tracer.extent
    met = tracer.first(point + off * normal, direction) != MISS
    assert len(at) >= 10000 and not met.any()


def test_dents_are_where_the_other_diagonal_lies_outside():
    """Half of the triangles of a pushed-out cube are in dents, those of single precision are nearly flat."""
    sine = sines(ball())
    assert (sine > 0).mean() == pytest.approx(0.5, abs=0.1)
    assert 0.05 < sine.max() < 0.3
    assert sines(moved(globe(), 3, 1.0)).max() < 1e-4


def lens(depth):
    """A disc whose upper side is hollow by `depth` of its radius, finely cut: no edge of it is bent by much."""
    radius, thick = np.linspace(0, 1, 65)[1:], 0.3
    u = np.arange(128) * 2 * np.pi / 128
    x, y = (np.outer(radius, f(u)).ravel() for f in (np.cos, np.sin))
    top = np.stack([x, y, np.repeat(thick + depth * radius**2, 128)], 1)
    at = np.arange(len(top)).reshape(64, 128)
    a, b, c, d = at[:-1], at[1:], np.roll(at[1:], -1, 1), np.roll(at[:-1], -1, 1)
    middle, low = len(top), len(top) + 1
    parts = [(a, b, c), (a, c, d), (np.full(128, middle), at[0], np.roll(at[0], -1))]
    parts.append((np.full(128, low), np.roll(at[-1], -1), at[-1]))
    triangles = np.concatenate([np.stack(part, -1).reshape(-1, 3) for part in parts])
    positions = np.concatenate([top, [[0, 0, thick], [0, 0, -0.5]]])
    v = positions[triangles]
    normals = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Caster("Lens", positions, triangles, normals, np.repeat(np.arange(len(normals))[:, None], 3, 1), GLASS)


@pytest.mark.parametrize("depth", [1e-3, 0.01, 0.1])
def test_a_hollow_that_is_cut_finely_is_no_dent(depth):
    assert sines(lens(depth)) is None
    assert sines(lens(-depth)) is not None


def twice_round():
    """Two pyramids on a pentagram's points, so that the faces go round twice: no edge is bent inwards."""
    angle = np.arange(5) * 4 * np.pi / 5
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(5)], 1)
    positions = np.concatenate([rim, [[0, 0, 1], [0, 0, -1]]])
    faces = [(k, (k + 1) % 5, 5) for k in range(5)] + [((k + 1) % 5, k, 6) for k in range(5)]
    return faceted(positions, faces)


def bowl():
    """A ball with a face beaten in."""
    mesh = globe()
    positions = mesh.positions.copy()
    positions[-2] *= 0.9
    return replace(mesh, positions=positions)


def hole():
    """A ball without one of its triangles."""
    mesh = ball()
    return replace(mesh, triangles=mesh.triangles[1:], normal_triangles=mesh.normal_triangles[1:])


def corner():
    """A block with another on its edge, one mesh."""
    return joined(slab((0, 0, 0), (1, 1, 1)), slab((1, 0, 0), (2, 1, 3)))


def sheet():
    """A wavy sheet."""
    unit = np.linspace(-1, 1, 9)
    return patch(lambda u, v: (u, v, 0.1 * u * v), lambda u, v: (-0.1 * v, -0.1 * u, 1 + 0 * u), unit, unit)


@pytest.mark.parametrize(
    "make",
    [
        twice_round,
        bowl,
        hole,
        corner,
        sheet,
        lambda: inside_out(ball()),
        lambda: joined(ball(), ball()),
        lambda: shapes.caster("Ring", shapes.ring(0.16, 0.035, (32, 16)), GLASS),
    ],
    ids=["twice round", "bowl", "hole", "corner", "sheet", "inside out", "two in one place", "ring"],
)
def test_what_is_not_convex_is_not_taken_for_it(make):
    assert sines(make()) is None
