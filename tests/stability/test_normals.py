"""Normals: below the horizon, zero, no numbers, flat, and the wrong way round."""

from dataclasses import replace

import numpy as np
import pytest
from waves import calm, faceted, flat, floor, mesh_water, pool, transmitted

from dapple.kernels.halfedges import build_twins
from dapple.kernels.scene import Water
from dapple.tests.stability.photons import constant, trace

SIDE = 16
COS_I = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
STILL = COS_I * transmitted(COS_I)


def leaning(scene, chosen, normal):
    """The scene with this normal at chosen vertices of its water."""
    normals = scene.water.normals.copy()
    normals[chosen] = normal
    return replace(scene, water=replace(scene.water, normals=normals))


@pytest.mark.parametrize("elevation", [45, 20, 10])
def test_interpolated_normals_below_the_horizon(every_method, elevation):
    """Some vertices' normals lean so far that the sun is below their horizon

    Fresnel's transmittance falls to 0 where light meets a normal edge on, and light that meets its back passes nothing:
    photons with the same interpolated normals.
    """
    e = np.radians(elevation)
    still = pool(flat, quads=24, direction=(np.cos(e), 0, -np.sin(e)), side=9.6, receivers=[floor(side=9.6)])
    scene = leaning(still, slice(None, None, 7), [0.9, 0.3, 0.3 / np.tan(e / 2)])
    assert (scene.water.normals @ -scene.lights[0].direction < 0).any()
    expected = trace(scene, SIDE, photons=600_000)
    every_method(scene, expected, SIDE)


@pytest.mark.parametrize("normal", [0.0, np.nan], ids=["zero", "not a number"])
def test_normals_that_are_none(every_method, normal):
    """Flat water, some of whose normals are this

    A normal that says nothing takes the facets' in its place, so the water is flat: E = E_sun cos i (1 - F).
    """
    scene = leaning(pool(flat, quads=24, side=12.0), slice(None, None, 17), [normal] * 3)
    every_method(scene, constant([STILL], SIDE), SIDE, 1e-5, 0.02)


def test_flat_shading(every_method):
    """Waves of flat facets

    Every facet moves its light as one piece, as a plane does: photons with the facets' normals.
    """
    scene = pool(calm, quads=24)
    scene = replace(scene, water=faceted(scene.water))
    every_method(scene, trace(scene, SIDE), SIDE)


def turned(water, flipped, normals):
    """Water with the winding of `flipped` triangles turned round, and other normals."""
    triangles = water.triangles.copy()
    triangles[flipped] = triangles[flipped][:, [0, 2, 1]]
    return mesh_water(water.positions, triangles, normals)


def test_winding_flipped_of_every_second_triangle(every_method):
    """Every second triangle wound the wrong way, normals as they should be

    Light is bent by normals, not by winding: the photons of the mesh as it was.
    """
    scene = pool(calm, quads=64)
    expected = trace(scene, SIDE)
    wound = turned(scene.water, slice(None, None, 2), scene.water.normals)
    every_method(replace(scene, water=wound), expected, SIDE)


def test_surface_inside_out(every_method):
    """The whole surface wound the wrong way, its normals downward

    Water lies below its surface whichever way the artist wound it: the photons of the surface as it should be.
    """
    scene = pool(calm, quads=64)
    expected = trace(scene, SIDE)
    over = turned(scene.water, slice(None), -scene.water.normals)
    every_method(replace(scene, water=over), expected, SIDE)


def test_patch_inside_out(every_method):
    """A quarter of the surface wound the wrong way, with the facets' normals

    A facet that faces away from the sun is the far side of a body of water, and takes no light; that a patch is no body
    is for the record to say.
    """
    scene = pool(flat, quads=24, side=12.0)
    centre = scene.water.positions[scene.water.triangles].mean(1)
    patch = (centre[:, 0] > 0) & (centre[:, 1] > 0)
    over = turned(scene.water, patch, scene.water.normals)
    facets = faceted(over)
    scene = replace(
        scene,
        water=Water(
            "Water",
            over.positions,
            over.triangles,
            facets.normals,
            facets.normal_triangles,
            build_twins(over.triangles),
        ),
    )
    every_method(scene, constant([STILL], SIDE), SIDE, 1e-5, 0.02, right=(), sentences=("wound against",))
