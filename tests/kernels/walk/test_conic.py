"""The conic: its coefficients, its crossings with edges, the order of points on it, and known awkward triangles."""

import json
from pathlib import Path

import numpy as np
import pytest
from waves import OBLIQUE, sun

from dapple.kernels.halfedges import build_twins
from dapple.kernels.lit_water import light_water
from dapple.kernels.scene import Water
from dapple.kernels.walk.conic import (
    FORWARD,
    conic,
    crossing_points,
    edge_crossings,
    edge_root,
    follow,
    has_double_root,
    is_path,
    objective,
    tangent,
)
from dapple.kernels.walk.conic_start import closed_curve_root
from dapple.kernels.walk.lit_surface import Surface

FIXTURES = json.loads((Path(__file__).parent / "conic_fixtures.json").read_text())
FIXTURE_ETA = 1.33


def triangle_surface(positions, normals, direction=OBLIQUE):
    """Surface of a single triangle in the sun's frame, and that frame."""
    triangles = np.array([[0, 1, 2]])
    water = Water("Triangle", positions, triangles, normals, triangles, build_twins(triangles))
    lit = light_water(water, sun(direction))
    return Surface(lit, water.twins), lit.frame


def load(name):
    """Surface, P (3,1) in the sun's frame and the known roots (n,2) of a fixture."""
    data = FIXTURES[name]
    normals = np.array(data["n"])
    surface, frame = triangle_surface(np.array(data["V"]), normals / np.linalg.norm(normals, axis=1, keepdims=True))
    return surface, frame @ np.array(data["P"])[:, None], np.array(data["roots"])


def coefficients_of(surface, p):
    corner = surface.corner_records(np.array([0])).T
    m = np.stack([np.take(c, corner) for c in surface.m], 1)
    n = np.stack([np.take(c, corner) for c in surface.n], 1)
    return conic(m, n, p[0], p[1])


def test_conic_is_the_coplanarity_of_light_path_and_normal():
    rng = np.random.default_rng(0)
    positions = rng.normal(size=(3, 3))
    normals = rng.normal(size=(3, 3)) * 0.3 + [0, 0, 1]
    direction = np.array(OBLIQUE) / np.linalg.norm(OBLIQUE)
    surface, frame = triangle_surface(positions, normals)
    p_world = np.array([0.2, -0.4, -2.0])
    A, B, C, D, E, F = coefficients_of(surface, (frame @ p_world)[:, None])[:, 0]
    for a, b in rng.random((50, 2)):
        m = positions[0] + a * (positions[1] - positions[0]) + b * (positions[2] - positions[0])
        n = normals[0] + a * (normals[1] - normals[0]) + b * (normals[2] - normals[0])
        triple = n @ np.cross(direction, m - p_world)
        g = A * a * a + B * b * b + C * a * b + D * a + E * b + F
        assert abs(abs(triple) - abs(g)) < 1e-12


@pytest.mark.parametrize("name", FIXTURES)
def test_known_roots_lie_on_the_conic_and_bend_to_the_normal(name):
    surface, p, roots = load(name)
    A, B, C, D, E, F = coefficients_of(surface, p)[:, 0]
    for a, b in roots:
        scale = np.abs([A, B, C, D, E, F]).max()
        assert abs(A * a * a + B * b * b + C * a * b + D * a + E * b + F) < 2e-5 * scale
        m, n = surface.at(np.array([0]), np.array([[1 - a - b, a, b]]))
        f = objective(m, n, p, FIXTURE_ETA, FORWARD)
        assert abs(f[0]) < 5e-5  # six digits are known of the roots
        w = p - np.stack(m)
        assert n[0] * w[0] + n[1] * w[1] < 1e-6 and -w[2] > np.linalg.norm(w) / FIXTURE_ETA


@pytest.mark.parametrize("name", [n for n in FIXTURES if "crossings" in FIXTURES[n]])
def test_edges_are_crossed_as_often_as_known(name):
    surface, p, _ = load(name)
    corner = surface.corner_records(np.array([0])).T
    g = np.stack([surface.g(c, p[0], p[1]) for c in corner], 1)
    shares = edge_crossings(g, surface.k.reshape(-1, 3))[0]
    # The fixtures count per edge as a = 0 (corner 2 to 0), b = 0 (0 to 1), a + b = 1 (1 to 2).
    found = np.isfinite(shares).sum(1)[[2, 0, 1]]
    np.testing.assert_array_equal(found, FIXTURES[name]["crossings"])


def test_a_curve_inside_its_triangle_gives_its_root():
    surface, p, roots = load("ellipse_inside_with_root")
    a, b = roots[0]
    # Any point of the curve may be the start; take the one where the straight ray hits.
    from dapple.kernels.walk.conic_start import locate

    triangle, weights = locate(surface, np.array([0]), p[0], p[1])
    found = closed_curve_root(surface, triangle, weights, p, FIXTURE_ETA)
    np.testing.assert_allclose(found[0, 1:], [a, b], atol=2e-3)
    m, n = surface.at(triangle, found)
    assert is_path(m, n, p, FIXTURE_ETA).all()


def test_a_curve_that_is_a_point_has_no_root():
    """Normals that turn round the light, and P on their axis: g = 0 at M0 alone."""
    positions = np.array([[-1.0, -1, 0], [2, -1, 0], [-1, 2, 0]])
    normals = np.column_stack([-0.3 * positions[:, 1], 0.3 * positions[:, 0], np.ones(3)])
    surface, frame = triangle_surface(positions, normals, (0, 0, -1))
    p = frame @ np.array([[0.0], [0], [-2]])
    with np.errstate(all="raise"):
        found = closed_curve_root(surface, np.array([0]), np.array([[1 / 3, 1 / 3, 1 / 3]]), p, FIXTURE_ETA)
    assert np.isnan(found).all()


def test_edge_roots_are_roots():
    rng = np.random.default_rng(4)
    p, q, k = rng.normal(size=(3, 2000)) * rng.choice([1e-9, 1e-3, 1.0], size=(3, 2000))
    sign_change = (p < 0) != (q < 0)
    s = edge_root(p[sign_change], q[sign_change], k[sign_change])
    p, q, k = p[sign_change], q[sign_change], k[sign_change]
    value = p + (q - p - k) * s + k * s * s
    assert (np.abs(value) < 1e-13 * (np.abs(p) + np.abs(q) + np.abs(k))).all()
    assert ((s >= 0) & (s <= 1)).all() and len(s) > 800


def test_double_roots_are_found_where_sampling_finds_them():
    rng = np.random.default_rng(5)
    p, q, k = rng.normal(size=(3, 4000))
    same = (p < 0) == (q < 0)
    p, q, k = p[same], q[same], k[same]
    s = np.linspace(0, 1, 2001)
    curve = p[:, None] + (q - p - k)[:, None] * s + k[:, None] * s * s
    sampled = ((curve[:, 1:] < 0) != (curve[:, :-1] < 0)).sum(1) == 2
    said = has_double_root(p, q, k)
    # Roots closer together than the sampling may be missed by it, never the other way round.
    assert not (sampled & ~said).any()
    assert (said & ~sampled).sum() < 0.02 * said.sum() and said.sum() > 50


def test_follow_meets_the_crossings_in_their_order_on_an_ellipse():
    # An ellipse through all three edges, six crossings; walking round it must visit them in the order of its angle.
    centre, radius = np.array([0.2929, 0.2929]), 0.31
    shift = centre
    A = B = np.array([1.0])
    C = np.array([0.0])
    D, E = -2 * shift[:1], -2 * shift[1:]
    F = np.array([shift @ shift - radius**2])
    coefficients = np.stack([A, B, C, D, E, F])
    corner = np.array([[0, 0], [1, 0], [0, 1]])
    g = ((corner - centre) ** 2).sum(1) - radius**2
    edge = corner[[1, 2, 0]] - corner
    shares = edge_crossings(g[None], (edge**2).sum(1)[None]).reshape(1, 6)
    points = crossing_points(shares)
    exists = np.flatnonzero(np.isfinite(shares[0]))
    assert len(exists) >= 4
    polar = np.arctan2(points[0, :, 1] - centre[1], points[0, :, 0] - centre[0])
    checked = 0
    for index in exists:
        start = points[0, index][:, None]
        along, gradient = tangent(coefficients, *start)
        sense = np.sign(along[0, 0] * -(start[1, 0] - centre[1]) + along[1, 0] * (start[0, 0] - centre[0]))
        others = shares.copy()
        others[0, index] = np.nan
        # From outside to inside the ellipse the rim enters it; the curve itself leaves the triangle at every other one.
        turn = (sense * (polar - polar[index])) % (2 * np.pi)
        turn[index] = np.inf
        inward = np.array([[0.0, 1.0], [-1.0, -1.0], [1.0, 0.0]])[index // 2] @ along[:, 0]
        if inward < 0:
            along, turn = -along, (sense * (polar[index] - polar)) % (2 * np.pi)
            turn[index] = np.inf
        found, some = follow(coefficients, start, along, gradient, others, g[None])
        assert some[0] and found[0] == np.nanargmin(turn)
        checked += 1
    assert checked == len(exists)
