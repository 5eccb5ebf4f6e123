"""All roots: against a brute-force search, by the odd count and the winding number, on floors, terrain and walls."""

from dataclasses import replace

import numpy as np
import pytest
from brute_force import all_roots
from waves import faceted, five_sines, flat, floor, grid, pool, quad

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.rays import Tracer, soup
from dapple.kernels.scene import Receiver
from dapple.kernels.walk.all_roots import find_roots
from dapple.kernels.walk.candidates import Grid
from dapple.kernels.walk.certificate import missing, whole_triangles
from dapple.kernels.walk.conic import is_path
from dapple.kernels.walk.paths import LightPaths
from dapple.kernels.walk.plan import Rays


def paths_of(scene):
    solids = soup((*scene.receivers, *scene.occluders))
    return LightPaths(scene, scene.lights[0], Tracer(*solids), solids)


def roots_of(scene, points):
    """Roots of points (n,3), with the surface and the points in the frame of the light."""
    paths = paths_of(scene)
    p = paths.lit.frame @ points.T
    rays = Rays(paths.surface, scene.eta)
    return find_roots(paths.surface, Grid(rays, p), np.flatnonzero(paths.lit.area), p, scene.eta), paths.surface, p


def test_brute_force_finds_the_same_roots():
    """Newton's method from 12 starts in every triangle, for every point, finds these roots and no others."""
    scene = pool(lambda x, y: five_sines(x, y, 3.0), quads=12)
    rng = np.random.default_rng(3)
    points = np.column_stack([rng.uniform(-1, 1, (100, 2)), rng.uniform(-3, 0.5, 100)])
    roots, surface, p = roots_of(scene, points)
    m, n = surface.at(roots.triangle, roots.weights)
    assert is_path(m, n, p[:, roots.point], scene.eta).all() and (roots.weights > -1e-8).all()
    several = 0
    for k, searched in enumerate(all_roots(scene, points)):
        own = roots.point == k
        ours = np.column_stack([roots.triangle[own], roots.weights[own]])
        inner = searched[searched[:, 1:].min(1) > 1e-6]
        assert (ours[:, 1:].min(1) > 1e-6).all()
        assert len(ours) == len(inner)
        several += len(ours) > 1
        for root in inner:
            same = ours[ours[:, 0] == root[0]]
            assert np.abs(same[:, 1:] - root[1:]).max(1).min() < 1e-4
    assert several >= 10, "the waves must focus, or the test shows nothing"


@pytest.mark.parametrize("scale", [0.3, 1.0, 2.0])
@pytest.mark.parametrize("degrees", [0, 25, 60])
@pytest.mark.parametrize("depth", [0.5, 1.5, 4.0])
def test_under_wide_water_the_count_is_odd_and_the_signed_count_one(scale, degrees, depth):
    angle = np.radians(degrees)
    direction = 0.8 * np.sin(angle), 0.6 * np.sin(angle), -np.cos(angle)
    scene = pool(lambda x, y: five_sines(x, y, scale), quads=96, direction=direction, side=12.0)
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-1, 1, (1500, 2)), np.full(1500, 1.5 - depth)])
    found = paths_of(scene).to(points, np.tile([0.0, 0, 1], (1500, 1)))
    count = np.bincount(found.point, minlength=1500)
    assert not found.missing.any()
    assert (count % 2 == 1).all()


def terrain():
    x, y, triangles = grid(24, 4.0)
    uv = np.stack([(x + 2) / 4, (y + 2) / 4], 1)
    return Receiver("Terrain", np.stack([x, y, 0.3 * np.sin(2 * x) * np.cos(3 * y)], 1), triangles, uv[triangles])


def wall():
    return quad("Wall", [[1, -1, 0], [1, 1, 0], [1, 1, 1.3], [1, -1, 1.3]])


@pytest.mark.parametrize("receiver", [terrain, wall])
def test_receivers_of_any_shape_have_all_paths(receiver):
    """Layers of depth lose nothing: point by point as a plane floor through the point alone would find them."""
    scene = pool(lambda x, y: five_sines(x, y, 2.0), quads=96, side=9.6, receivers=[receiver()])
    own = rasterise(scene.receivers[0], 48)
    found = paths_of(scene).to(own.positions, own.normals)
    count = np.bincount(found.point, minlength=len(own.texel))
    assert not found.missing.any() and (count % 2 == 1).all()
    assert (count > 1).any()
    some = np.random.default_rng(0).choice(len(own.texel), 40, replace=False)
    for k in some:
        alone, *_ = roots_of(scene, own.positions[k : k + 1])
        assert len(alone.point) == count[k]


def test_the_certificate_knows_a_root_that_is_taken_away_or_doubled():
    scene = pool(quads=64, receivers=[floor(side=1.0)])
    own = rasterise(scene.receivers[0], 16)
    roots, surface, p = roots_of(scene, own.positions)
    grid_ = Grid(Rays(surface, scene.eta), p)
    whole = whole_triangles(surface, np.arange(len(scene.water.triangles)))
    turn = paths_of(scene).factors(roots.triangle, roots.weights, own.positions[roots.point], own.normals[roots.point])
    turn = np.sign(turn[1])
    assert not missing(surface, grid_, whole, roots, turn, 256).any()
    less = np.arange(1, len(roots.point))
    assert missing(surface, grid_, whole, roots.take(less), turn[less], 256).sum() == 1
    more = np.concatenate([[0], np.arange(len(roots.point))])
    assert missing(surface, grid_, whole, roots.take(more), turn[more], 256).sum() == 1


def test_beyond_the_rim_no_path_is_expected():
    """Half of the floor lies beside the water: nothing arrives there, and nothing is claimed to be missing."""
    scene = pool(flat, quads=16, direction=(0, 0, -1), side=2.0)
    own = rasterise(scene.receivers[0], 32)
    found = paths_of(scene).to(own.positions, own.normals)
    count = np.bincount(found.point, minlength=len(own.texel))
    assert not found.missing.any()
    np.testing.assert_array_equal(count, np.abs(own.positions[:, :2]).max(1) < 1.0)


def test_facets_are_solved_one_by_one():
    """Flat shading tears the map: gaps and overlaps, and in each facet at most the one path of a tilted plane."""
    smooth = pool(quads=24)
    scene = replace(smooth, water=faceted(smooth.water))
    own = rasterise(scene.receivers[0], 64)
    found = paths_of(scene).to(own.positions, own.normals)
    count = np.bincount(found.point, minlength=len(own.texel))
    assert (count == 0).any() and (count > 1).any()
    light = np.bincount(found.point, found.passed * found.density, minlength=len(own.texel))
    assert light.mean() == pytest.approx(0.944, rel=0.01), "facets send all of the light somewhere"
