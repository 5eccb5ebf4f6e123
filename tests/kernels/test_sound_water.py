"""Water that cannot be trusted is mended where that is possible, and what was done is said."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball, no_water
from waves import five_sines, floor, mesh_water, sun, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Scene, Settings, Water
from dapple.kernels.sound_water import sound_water


@pytest.fixture
def waves():
    return water(five_sines, 12)


def with_triangles(w, triangles):
    return mesh_water(w.positions, triangles, w.normals)


def test_sound_water_is_left_alone(waves):
    mended, sentences = sound_water(waves)
    assert mended is waves and sentences == []


def test_positions_must_be_numbers(waves):
    waves.positions[[3, 7], 2] = np.nan
    with pytest.raises(ValueError, match=r"positions must be finite, but 2 of 169 are not"):
        sound_water(waves)


@pytest.mark.parametrize("copies", [1, 2])
def test_repeats_go_whatever_their_winding(waves, copies):
    """At the rim, inside, next to each other, and a triangle apart from all others."""
    w = with_triangles(waves, waves.triangles[:200])
    again = np.concatenate([w.triangles[[0, 1, 2, 50, 51, 199]]] * copies)
    again[::2] = again[::2][:, [2, 1, 0]]
    mended, (sentence,) = sound_water(with_triangles(w, np.concatenate([w.triangles, again])))
    np.testing.assert_array_equal(mended.triangles, w.triangles)
    np.testing.assert_array_equal(mended.twins, w.twins)
    assert mended.normal_triangles is mended.triangles
    assert sentence.startswith(f"{6 * copies} triangles")


def test_triangles_with_a_corner_twice_go_without_a_word(waves):
    a, b, c = waves.triangles[30]
    mended, sentences = sound_water(with_triangles(waves, np.concatenate([waves.triangles, [[a, a, b], [c, b, c]]])))
    np.testing.assert_array_equal(mended.twins, waves.twins)
    assert sentences == []


def test_a_lone_triangle_twice(waves):
    once = with_triangles(waves, waves.triangles[:1])
    mended, _ = sound_water(with_triangles(waves, np.repeat(once.triangles, 2, axis=0)))
    np.testing.assert_array_equal(mended.triangles, once.triangles)


def test_repeats_keep_the_normals_of_corners(waves):
    rows = np.arange(3 * len(waves.triangles)).reshape(-1, 3)
    triangles, rows = (np.concatenate([a, a[5:9]]) for a in (waves.triangles, rows))
    corners = waves.normals[waves.triangles.ravel()]
    mended, _ = sound_water(Water("Corners", waves.positions, triangles, corners, rows, build_twins(triangles)))
    np.testing.assert_array_equal(mended.normal_triangles, rows[:-4])


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_normals_that_are_none_become_the_facets(waves, bad, up):
    """Exact on a plane, on the side of the normals round them whatever the winding."""
    x, y = waves.positions[:, 0], waves.positions[:, 1]
    plane = np.stack([x, y, 0.3 * x - 0.1 * y], 1)
    n = up * np.array([-0.3, 0.1, 1.0]) / np.sqrt(1.1)
    normals = np.tile(n, (len(plane), 1))
    normals[[0, 40, 41, 100]] = bad
    mended, (sentence,) = sound_water(replace(waves, positions=plane, normals=normals))
    np.testing.assert_allclose(mended.normals, np.tile(n, (len(plane), 1)), atol=1e-12)
    assert sentence.startswith("4 normals")


def test_normals_of_triangles_without_area_are_at_least_directions():
    line = np.column_stack([np.arange(3.0), np.zeros(3), np.zeros(3)])
    mended, _ = sound_water(mesh_water(line, np.array([[0, 1, 2]]), np.zeros((3, 3))))
    np.testing.assert_array_equal(mended.normals, np.tile([0, 0, 1.0], (3, 1)))


def test_normals_that_nothing_uses_do_not_matter(waves):
    loose = replace(
        waves, positions=np.vstack([waves.positions, np.zeros(3)]), normals=np.vstack([waves.normals, np.zeros(3)])
    )
    assert sound_water(loose)[1] == []


def test_winding_that_turns_round_is_said_only_where_normals_follow_it(waves):
    triangles = waves.triangles.copy()
    patch = slice(100, 110)
    triangles[patch] = triangles[patch][:, ::-1]
    assert sound_water(with_triangles(waves, triangles))[1] == []
    v = waves.positions[triangles]
    facets = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    rows = np.repeat(np.arange(len(facets))[:, None], 3, 1)
    follows = Water("Patch", waves.positions, triangles, facets, rows, build_twins(triangles))
    (sentence,) = sound_water(follows)[1]
    assert "wound against their neighbours, along 12 edges" in sentence


def test_normals_of_glass_that_are_no_numbers_become_those_of_its_facets():
    """As a deformed mesh may have them; light through them would have no number either."""
    lit = Scene(no_water(), (floor(side=1.0),), (), (sun((0.3, 0.2, -1)),), casters=(ball(0.2, (0, 0, 0.3), fine=24),))
    own = [rasterise(lit.receivers[0], 24)]
    settings = Settings("photon_splat", resolution=24)
    broken = lit.casters[0].normals.copy()
    broken[:3] = [np.inf, 0, 0], [np.nan, 0, 1], [0, 0, 0]
    found, expected = (
        solve(replace(lit, casters=(replace(lit.casters[0], normals=normals),)), own, settings)
        for normals in (broken, lit.casters[0].normals)
    )
    assert "3 normals of 'Ball' that are zero or no numbers: the facets' stand in" in found.diagnostics.left_out
    assert found.diagnostics.flux_in == pytest.approx(expected.diagnostics.flux_in, rel=1e-2)
    np.testing.assert_allclose(found.images[0].mean(), expected.images[0].mean(), rtol=1e-2)
