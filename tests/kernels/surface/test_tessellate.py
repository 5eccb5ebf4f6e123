"""Triangles in parts: areas, adjacency, and no crack."""

import numpy as np
import pytest
from waves import grid

from dapple.kernels.halfedges import build_twins
from dapple.kernels.surface.tessellate import Tessellation


def awkward():
    """A bumpy grid with a fin on an inner edge, a triangle wound backwards, and two triangles apart from the rest."""
    x, y, triangles = grid(5, 2.0)
    positions = np.stack([x, y, 0.1 * np.sin(3 * x)], 1)
    positions = np.concatenate([positions, [[0, 0, 1.0], [5, 5, 0], [6, 5, 0], [6, 6, 0], [5, 6, 0]]])
    triangles = np.concatenate([triangles, [[7, 8, 36], [37, 38, 39], [37, 39, 40]]])
    triangles[5] = triangles[5][::-1]
    return positions, triangles


def vertices(tessellation, positions):
    along, inside = tessellation.shares()
    parts = [positions]
    for ends, shares in ((tessellation.ends, along), (tessellation.inner, inside)):
        parts.append(np.einsum("cnd,cm->nmd", positions[ends], shares).reshape(-1, 3))
    return np.concatenate(parts)


def areas(positions, triangles):
    v = positions[triangles]
    return np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1) / 2


@pytest.mark.parametrize("k", [1, 2, 3, 4, 7])
def test_parts_tile_their_triangles_and_know_their_neighbours(k):
    positions, triangles = awkward()
    cut = np.arange(len(triangles)) < len(triangles) - 2
    parts = Tessellation(triangles, build_twins(triangles), len(positions), cut, k)
    fine = vertices(parts, positions)
    assert len(fine) == parts.count and len(parts.triangles) == k * k * cut.sum() + 2
    expected = np.concatenate([np.repeat(areas(positions, triangles[cut]) / k**2, k * k), [0.5, 0.5]])
    np.testing.assert_allclose(areas(fine, parts.triangles), expected, rtol=1e-9)
    np.testing.assert_array_equal(parts.twins, build_twins(parts.triangles))


def test_both_sides_of_an_edge_share_its_vertices_the_fins_too():
    positions, triangles = awkward()
    parts = Tessellation(triangles, build_twins(triangles), len(positions), np.ones(len(triangles), bool), 4)
    fine = vertices(parts, positions)
    assert len(np.unique(np.round(fine, 9), axis=0)) == len(fine)


def test_winding_stays():
    positions, triangles = awkward()
    flat = positions * [1, 1, 0]
    parts = Tessellation(triangles, build_twins(triangles), len(positions), np.ones(len(triangles), bool), 3)

    def up(p, t):
        v = p[t]
        return np.sign(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])[:, 2])

    fin = np.arange(len(triangles)) == len(triangles) - 3
    np.testing.assert_array_equal(up(vertices(parts, flat), parts.triangles)[~np.repeat(fin, 9)],
                                  np.repeat(up(flat, triangles)[~fin], 9))  # fmt: skip


def test_a_tetrahedron_and_two_triangles_back_to_back():
    for triangles in ([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [[0, 1, 2], [0, 2, 1]]):
        triangles = np.array(triangles)
        parts = Tessellation(triangles, build_twins(triangles), 4, np.ones(len(triangles), bool), 3)
        assert (parts.twins >= 0).all()
        np.testing.assert_array_equal(parts.twins[parts.twins], np.arange(len(parts.twins)))
