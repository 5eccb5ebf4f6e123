"""The walk against closed forms, against a brute-force search, and against its own statuses."""

from dataclasses import replace

import numpy as np
import pytest
from brute_force import all_roots
from waves import calm, faceted, five_sines, flat, floor, mesh_water, pool, transmitted, water

from dapple.kernels.lit_water import light_water
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.rays import Tracer
from dapple.kernels.scene import Occluder, Settings, Water
from dapple.kernels.status import Status
from dapple.kernels.walk.conic_walk import solve
from dapple.kernels.walk.lit_surface import Surface
from dapple.kernels.walk.walkers import Walk


def bake(scene, resolution=32, first_root=False):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(method="conic_walk", first_root=first_root))


@pytest.mark.parametrize("degrees", [0.0, 10.0, 30.0, 45.0])
@pytest.mark.parametrize("depth", [0.3, 1.5])
@pytest.mark.parametrize("first_root", [False, True])
def test_flat_water_is_fresnel_times_cosine(degrees, depth, first_root):
    """Flat water bends all light alike: E = E_sun cos_i T at every depth, and overhead, where all is coplanar."""
    angle = np.radians(degrees)
    scene = pool(
        flat, quads=24, direction=(np.sin(angle), 0, -np.cos(angle)), side=12.0, receivers=[floor(z=1.5 - depth)]
    )
    image = bake(scene, first_root=first_root).images[0]
    expected = np.cos(angle) * transmitted(np.cos(angle))
    np.testing.assert_allclose(image, expected, rtol=1e-9)


def test_thirty_degrees_gives_the_known_figure():
    scene = pool(flat, quads=16, direction=(0.5, 0, -np.sqrt(0.75)), side=12.0)
    np.testing.assert_allclose(bake(scene).images[0], 0.8475, atol=5e-5)


@pytest.mark.parametrize("first_root", [False, True])
def test_flat_water_through_vertices_and_along_edges(first_root):
    """Texel centres under the mesh's vertices, a sun along its edges: zero counts as positive, nothing is lost."""
    scene = pool(flat, quads=48, direction=(0.4, 0, -1), side=12.0)
    answer = bake(scene, 16, first_root)  # centres at odd multiples of 1/8 m, vertices at multiples of 1/4 m
    assert (answer.status[0] == Status.LIT).all()
    cos_i = 1 / np.hypot(1, 0.4)
    np.testing.assert_allclose(answer.images[0], cos_i * transmitted(cos_i), rtol=1e-9)


def test_crest_focuses_at_its_focal_length():
    """A crest of radius R under an overhead sun brings paraxial light together R eta / (eta - 1) below it."""
    radius, eta = 1.0, 1.333
    focal = radius * eta / (eta - 1)

    def crest(x, y):
        sphere = np.sqrt(radius**2 - x**2 - y**2)
        return sphere - radius, -x / sphere, -y / sphere

    for share, expected in ((0.5, 4.0), (0.8, 25.0), (2.0, 1.0), (1.2, 25.0)):
        # On the axis the cone of light has shrunk by |1 - depth / focal| in both directions.
        depth = share * focal
        scene = pool(
            crest, quads=129, direction=(0, 0, -1), side=0.2, receivers=[floor(side=1e-4, z=1.5 - depth)], eta=eta
        )
        middle = bake(scene, 1, first_root=True).images[0][0, 0, 0]
        assert middle == pytest.approx(expected * transmitted(1.0, eta), rel=2e-3)


def test_the_walk_finds_a_root_that_brute_force_finds():
    scene = pool(quads=12, side=4.8)
    rng = np.random.default_rng(8)
    points = np.column_stack([rng.uniform(-1, 1, (40, 2)), np.zeros(40)])
    lit = light_water(scene.water, scene.lights[0])
    surface = Surface(lit, scene.water.twins)
    first = Tracer(scene.water.positions, scene.water.triangles).first(points, np.tile(lit.frame[2], (40, 1)))
    walk = Walk(surface, lit.frame @ points.T, first, scene.eta).run()
    checked = 0
    for k, roots in enumerate(all_roots(scene, points)):
        assert len(roots), "the search must find a path to every point under the water"
        if walk.status[k] != Status.LIT:
            continue
        same = roots[roots[:, 0] == walk.triangle[k]]
        assert len(same) and np.abs(same[:, 1:] - walk.weights[k]).max(1).min() < 1e-4
        checked += 1
    assert checked >= 38


def test_calm_water_lights_every_texel_with_all_its_light():
    answer = bake(pool(calm), resolution=128)
    assert (answer.status[0] == Status.LIT).all()
    d = answer.diagnostics
    # Mean irradiance of the pool is known to be close to cos_i T; calm water only moves light about.
    cos_i = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
    assert d.flux_received["Floor"][0] / 16 == pytest.approx(cos_i * transmitted(cos_i), rel=4e-3)
    assert d.texels == {"lit": 128 * 128}


def test_first_root_loses_light_on_the_full_waves():
    """What the method leaves out is real: a quarter of the light of the pool is in second and third paths."""
    received = bake(pool(quads=128), 128, first_root=True).diagnostics.flux_received["Floor"][0]
    assert 0.60 < received / 16 / 0.944 < 0.82


def test_blocked_paths_say_so():
    # A dark raft on the water, and one below it; each hides part of the floor and nothing else.
    for z in (1.9, 0.7):
        raft = floor(side=1.0, z=z)
        scene = pool(flat, quads=32, side=12.0, occluders=[Occluder("Raft", raft.positions, raft.triangles)])
        answer = bake(scene, resolution=64)
        blocked = answer.status[0] == Status.BLOCKED
        assert (answer.images[0][blocked] == 0).all()
        assert blocked.sum() / 64**2 * 16 == pytest.approx(1.0, abs=0.07)  # parallel light: a shadow of 1 m^2
        assert answer.diagnostics.texels["blocked"] == blocked.sum()


def test_no_water_over_a_texel_says_so():
    scene = pool(flat, quads=8, direction=(0, 0, -1), side=2.0)
    answer = bake(scene, resolution=16)
    assert (answer.status[0] == Status.NO_WATER).sum() == 16 * 16 - 8 * 8


@pytest.mark.parametrize("first_root", [False, True])
def test_winding_does_not_matter(first_root):
    straight = pool(calm, quads=24)
    w = straight.water
    turned = w.triangles.copy()
    turned[::2] = turned[::2, [0, 2, 1]]
    scene = replace(straight, water=mesh_water(w.positions, turned, w.normals))
    mixed, plain = (bake(s, first_root=first_root).images[0] for s in (scene, straight))
    np.testing.assert_allclose(mixed, plain, rtol=1e-9)


def test_flat_shading_is_reported_and_never_silently_wrong_by_first_roots():
    """Facets tear the curve: texels are lit by a path that is exact for the facets, or say that they are not."""
    smooth = pool(calm, quads=24)
    scene = replace(smooth, water=faceted(smooth.water))
    answer = bake(scene, first_root=True)
    lit = answer.status[0] == Status.LIT
    assert set(np.unique(answer.status[0])) <= {
        Status.LIT,
        Status.TORN,
        Status.OFF_THE_RIM,
        Status.NO_ROOT,
        Status.LOST,
    }
    assert lit.any() and (~lit).any()
    # Inside a facet nothing is focused: the light of each path is that of a tilted plane.
    assert np.abs(answer.images[0][lit] / 0.944 - 1).max() < 0.1


def test_texels_must_match_receivers():
    with pytest.raises(ValueError, match="one entry per receiver"):
        solve(pool(five_sines, quads=4), [], Settings())


def test_water_without_triangles_lights_nothing():
    empty = np.zeros((0, 3), int)
    dry = Water("Dry", water(flat, 2).positions, empty, np.zeros((0, 3)), empty, np.zeros(0, int))
    scene = replace(pool(flat, quads=2), water=dry)
    answer = bake(scene, resolution=4)
    assert (answer.status[0] == Status.NO_WATER).all() and not answer.images[0].any()


@pytest.mark.parametrize("scale", [0.0, 0.3, 1.0, 2.0])
@pytest.mark.parametrize("lean", [0.0, 1e-9, 1e-6, 1e-3, 0.25, 1.0])
@pytest.mark.parametrize("first_root", [False, True])
def test_every_texel_under_wide_water_finds_a_path(scale, lean, first_root):
    """Every point deep under water that reaches far beyond it is lit by an odd number of paths, so by one at least.

    Grid, texels and the sun's heading are aligned on purpose: curves pass vertices and edges, and rays hit them.
    """
    scene = pool(lambda x, y: five_sines(x, y, scale), quads=96, direction=(lean, 0, -1), side=9.6)
    answer = bake(scene, 48, first_root)
    assert (answer.status[0] == Status.LIT).all()
    assert np.isfinite(answer.images[0]).all() and (answer.images[0] > 0).all()
