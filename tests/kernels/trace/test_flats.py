"""Rays that meet planes in closed form, against the ray library, and which meshes are planes."""

from dataclasses import replace

import numpy as np
import pytest
from casters import GLASS, patch, slab
from waves import floor, grid, quad

from dapple.kernels.rays import MISS, Tracer, soup
from dapple.kernels.scene import Occluder, Receiver
from dapple.kernels.splat.lander import texel_maps
from dapple.kernels.trace.flats import Flats, parts


def table(quads=8, shape=lambda x, y: 0 * x, warp=lambda u, v: (u, v)):
    """A Receiver of many quads, turned, of which half a side is missing nowhere."""
    x, y, triangles = grid(quads, 2.0)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    uv = np.stack(warp(x / 2 + 0.5, y / 2 + 0.5), 1)
    return Receiver("Table", np.stack([x, y, shape(x, y)], 1) @ turn.T + [0, 0, 1], triangles, uv[triangles])


def walls():
    """Two walls of a room in one mesh."""
    one = quad("One", [[-1, -1, 0], [1, -1, 0], [1, -1, 1], [-1, -1, 1]], (0, 0), (0.4, 1))
    two = quad("Two", [[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]], (0.5, 0), (1, 1))
    positions, triangles = soup((one, two))
    return Receiver("Walls", positions, triangles, np.concatenate([one.uvs, two.uvs]))


@pytest.mark.parametrize("mesh", [floor(), table(), walls()], ids=["floor", "table", "walls"])
def test_planes_are_met_where_the_mesh_is(mesh):
    """Rays from both sides, many beside the outline: the same or none, on the same plane, at the same texels."""
    rng = np.random.default_rng(0)
    target = mesh.positions[rng.integers(0, len(mesh.positions), 20000)] + 0.4 * rng.normal(size=(20000, 3)) ** 3
    origin = rng.normal(size=(20000, 3)) * 2
    direction = target - origin
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    end, far = Flats(parts(mesh, 0)).first(origin.T, direction.T)
    met = Tracer(mesh.positions, mesh.triangles).first(origin, direction)
    differ = (end == MISS) != (met == MISS)
    assert differ.mean() < 1e-4 and 2000 < (met != MISS).sum() < 18000
    both = (end != MISS) & (met != MISS)
    point = np.concatenate([(origin + far[:, None] * direction)[both], np.ones((both.sum(), 1))], 1)
    maps = texel_maps(mesh, 256)
    (h, x, y), (own_h, own_x, own_y) = ((maps[k[both]] * point[:, None]).sum(2).T for k in (met, end))
    near = np.abs(h) < 1e-6  # but a few on the edge between two planes
    assert near.mean() > 1 - 1e-3 and np.abs(own_h).max() < 1e-9
    np.testing.assert_allclose(np.stack([own_x, own_y])[:, near], np.stack([x, y])[:, near], atol=1e-4)


def test_the_nearest_of_planes_is_met():
    low, high = floor(z=0.0), floor(side=1.0, z=0.5)
    flats = Flats([*parts(low, 0), *parts(high, 2)])
    origin = np.array([[0.2, 0.2, 1.9, 0.2, 9.0], [0.1, 0.1, 0.1, 0.1, 0.1], [1.0, -1.0, 1.0, 0.2, 1.0]])
    direction = np.zeros((3, 5))
    direction[2] = -1, 1, -1, -1, -1
    end, far = flats.first(origin, direction)
    np.testing.assert_array_equal(end // 2, [1, 0, 0, 0, MISS // 2])
    np.testing.assert_array_equal(far, [0.5, 1.0, 1.0, 0.2, np.inf])


def test_what_runs_along_a_plane_does_not_meet_it():
    origin, direction = np.array([[-3.0, -3.0], [0, 0], [0.0, 0.1]]), np.array([[1.0, 1.0], [0, 0], [0, 0]])
    with np.errstate(all="raise"):
        assert (Flats(parts(floor(), 0)).first(origin, direction)[0] == MISS).all()


def ell():
    """A table with a corner cut out."""
    whole = table(2)
    return replace(whole, triangles=whole.triangles[:-2], uvs=whole.uvs[:-2])


def seam():
    """A table of two halves, each with its own place in the map."""
    whole = table(2)
    uvs = whole.uvs.copy()
    uvs[:4] += 1e-3
    return replace(whole, uvs=uvs)


def folded():
    """A table one half of which is wound the other way."""
    whole = table(1)
    return replace(whole, triangles=np.concatenate([whole.triangles[:1], whole.triangles[1:, ::-1]]))


@pytest.mark.parametrize(
    "mesh",
    [
        ell(),
        seam(),
        table(8, lambda x, y: 1e-4 * x * y),
        table(8, warp=lambda u, v: (u + 0.01 * v * v, v)),
        slab((-1, -1, -1), (1, 1, 1)),
        patch(
            lambda u, v: (u, v, 0 * u),
            lambda u, v: (0.01 * u, 0 * u, 1 + 0 * u),
            np.linspace(-1, 1, 3),
            np.linspace(-1, 1, 3),
        ),
    ],
    ids=["ell", "seam", "uneven", "uneven map", "block", "smooth"],
)
def test_what_is_not_alike_all_over_is_no_plane(mesh):
    assert parts(mesh, 0) is None


def test_an_occluder_needs_no_map_and_glass_one_normal():
    x, y, triangles = grid(4, 2.0)
    positions = np.stack([x, y, 0 * x], 1)
    assert len(parts(Occluder("Board", positions, triangles), 7)) == 1
    pane = patch(lambda u, v: (u, v, 0 * u), lambda u, v: (0 * u, 0 * u, 1 + 0 * u), [-1, 0, 1], [-1, 1], GLASS)
    (part,) = parts(pane, 7)
    assert part[0] >= 7 and len(part[1]) == 5
    assert len(parts(folded(), 0)) == 2, "a front and a back are two"
