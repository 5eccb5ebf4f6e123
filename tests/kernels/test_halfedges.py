"""Adjacency against closed counts and against a table built edge by edge."""

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dapple.kernels.halfedges import build_twins, rim_length


def grid(n, m):
    """n x m quads, each cut in two: (2nm, 3)."""
    index = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    cut = [np.stack([a, b, c], -1), np.stack([a, c, d], -1)]
    return np.stack(cut, -2).reshape(-1, 3)


def octahedron(times):
    """A closed sphere: an octahedron, each triangle cut in four `times` times."""
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(times):
        count, middles, fine = 1 + max(map(max, triangles)), {}, []
        for a, b, c in triangles:
            edges = map(frozenset, ((a, b), (b, c), (c, a)))
            ab, bc, ca = (middles.setdefault(edge, count + len(middles)) for edge in edges)
            fine += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = fine
    return np.array(triangles)


def ends(triangles, half_edges):
    """Vertices at both ends of half-edges: (n,) -> (n,2)."""
    t, e = half_edges // 3, half_edges % 3
    return np.stack([triangles[t, e], triangles[t, (e + 1) % 3]], -1)


def twins_one_by_one(triangles):
    """The same by its definition."""
    sharing = defaultdict(list)
    for t, triangle in enumerate(triangles):
        for e in range(3):
            sharing[frozenset((triangle[e], triangle[(e + 1) % 3]))].append(3 * t + e)
    twins = np.full(3 * len(triangles), -1)
    for half_edges in sharing.values():
        if len(half_edges) == 2 and half_edges[0] // 3 != half_edges[1] // 3:
            twins[half_edges] = half_edges[::-1]
    return twins


def test_grid_has_its_rim_and_nothing_else_open():
    triangles = grid(7, 4)
    twins = build_twins(triangles)
    assert twins.dtype == np.int32
    rim = np.flatnonzero(twins == -1)
    assert len(rim) == 2 * (7 + 4)
    inner = np.flatnonzero(twins != -1)
    np.testing.assert_array_equal(twins[twins[inner]], inner)
    np.testing.assert_array_equal(ends(triangles, inner), ends(triangles, twins[inner])[:, ::-1])


def test_closed_sphere_satisfies_euler():
    triangles = octahedron(3)
    twins = build_twins(triangles)
    assert (twins >= 0).all()
    edges = np.count_nonzero(np.arange(len(twins)) < twins)
    assert len(np.unique(triangles)) - edges + len(triangles) == 2


def test_fin_on_an_edge_closes_it():
    triangles = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert (build_twins(triangles) == -1).all()


def test_flipped_neighbour_is_still_a_neighbour():
    twins = build_twins(np.array([[0, 1, 2], [0, 1, 3]]))
    np.testing.assert_array_equal(twins, [3, -1, -1, 0, -1, -1])


def test_triangle_is_not_its_own_neighbour():
    assert (build_twins(np.array([[0, 1, 0]])) == -1).all()


def test_no_triangles():
    assert build_twins(np.empty((0, 3), dtype=np.int32)).shape == (0,)


def test_wrong_shape_is_named():
    with pytest.raises(ValueError, match=r"\(n, 3\), got \(2, 4\)"):
        build_twins(np.zeros((2, 4), dtype=np.int32))


@given(st.lists(st.tuples(*[st.integers(0, 7)] * 3), min_size=1, max_size=40))
def test_any_soup_as_by_definition(soup):
    triangles = np.array(soup, dtype=np.int32)
    np.testing.assert_array_equal(build_twins(triangles), twins_one_by_one(triangles))


def test_vertex_numbers_that_overflow_32_bits_when_packed():
    triangles = grid(3, 3) + 2_000_000_000
    np.testing.assert_array_equal(build_twins(triangles.astype(np.int32)), build_twins(grid(3, 3)))


def test_the_rim_of_a_sheet_is_its_outline():
    x, y = np.meshgrid(np.linspace(0, 3, 4), np.linspace(0, 2, 3), indexing="ij")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1)
    assert rim_length(flat, grid(3, 2)) == pytest.approx(10)
    assert rim_length(flat, np.zeros((0, 3), int)) == 0


def test_closed_things_have_no_rim_though_their_corners_are_split():
    triangles = octahedron(1)
    corners = np.random.default_rng(0).normal(size=(triangles.max() + 1, 3))
    apart = np.arange(triangles.size).reshape(-1, 3)
    assert rim_length(corners, triangles) == 0
    assert rim_length(corners[triangles].reshape(-1, 3), apart) == 0
    v = corners[triangles[0]]
    hole = np.linalg.norm(v - np.roll(v, 1, 0), axis=1).sum()
    assert rim_length(corners[triangles].reshape(-1, 3), apart[1:]) == pytest.approx(hole)
