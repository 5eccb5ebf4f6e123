"""Meshes: rims, holes, joints that do not fit, triangles without area or twice there, fins, overhangs, droplets."""

from dataclasses import replace

import numpy as np
import pytest
from waves import calm, five_sines, flat, mesh_water, pool, transmitted, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.scene import Water
from dapple.tests.stability.constructions import curl, droplets, joined, with_triangles
from dapple.tests.stability.judge import TWICE
from dapple.tests.stability.photons import constant, trace

SIDE = 16
COS_I = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
STILL = COS_I * transmitted(COS_I)


def centres(surface):
    """Middle (T,3) of each triangle."""
    return surface.positions[surface.triangles].mean(1)


def test_rim_of_the_water(every_method):
    """Waves over half of the floor: the mesh ends above it

    What the water does not cover sends nothing: photons from the mesh that is there.
    """
    scene = pool(calm, quads=64, side=2.8)
    every_method(scene, trace(scene, SIDE), SIDE)


def test_hole_in_the_water(every_method):
    """A hole of half a metre in the waves

    As at the rim: photons from the mesh that is there.
    """
    scene = pool(calm, quads=64)
    keep = np.abs(centres(scene.water)[:, :2]).max(1) > 0.25
    scene = replace(scene, water=with_triangles(scene.water, scene.water.triangles[keep]))
    every_method(scene, trace(scene, SIDE), SIDE)


def test_triangles_without_area(every_method):
    """Triangles without area: with a corner twice, with two corners at one place, with corners in a line

    They take no light: the photons of the mesh without them.
    """
    scene = pool(calm, quads=64)
    w = scene.water
    twin = len(w.positions)
    positions, normals = np.concatenate([w.positions, w.positions[500:501]]), np.concatenate([w.normals, w.normals[:1]])
    none = np.array([[700, 700, 701], [500, twin, 501], [1000, 1001, 1002], [800, 800, 800]])
    triangles = np.concatenate([w.triangles[:999], none, w.triangles[999:]])
    every_method(replace(scene, water=mesh_water(positions, triangles, normals)), trace(scene, SIDE), SIDE)


def test_repeated_triangles(every_method):
    """Every seventh triangle is in the mesh twice, some turned round

    A surface that is named twice is there once: the photons of the mesh without the repeats.
    """
    scene = pool(calm, quads=64)
    again = scene.water.triangles[::7].copy()
    again[::2] = again[::2][:, [1, 2, 0]]
    again[::3] = again[::3][:, [0, 2, 1]]
    doubled = with_triangles(scene.water, np.concatenate([scene.water.triangles, again]))
    every_method(replace(scene, water=doubled), trace(scene, SIDE), SIDE)


@pytest.mark.parametrize("shape", [flat, calm], ids=["flat", "waves"])
def test_t_junctions(every_method, shape):
    """Two meshes of unlike spacing that meet along a line, their vertices not shared

    Both send what they cover; where waves leave a gap between the two, nothing comes: photons from the mesh.
    """
    coarse, fine = water(shape, 24, 4.8), water(shape, 64, 4.8)
    left = with_triangles(coarse, coarse.triangles[centres(coarse)[:, 0] < 0])
    right = with_triangles(fine, fine.triangles[centres(fine)[:, 0] > 0])
    scene = replace(pool(shape), water=joined(left, right))
    every_method(scene, trace(scene, SIDE), SIDE)


def finned(direction):
    """Flat water with upright triangles on some of its edges, which three triangles then share."""
    scene = pool(flat, quads=8, side=12.0, direction=direction)
    w = scene.water
    edges = w.triangles[2:128:9, :2]
    tips = w.positions[edges].mean(1) + np.array([0, 0, 0.3])
    fins = np.column_stack([edges, len(w.positions) + np.arange(len(edges))])
    positions = np.concatenate([w.positions, tips])
    along = w.positions[edges[:, 1]] - w.positions[edges[:, 0]]
    across = np.cross(along, [0, 0, 1.0])
    normals = np.concatenate([w.normals, across / np.linalg.norm(across, axis=1, keepdims=True)])
    rows = len(w.positions) + np.repeat(np.arange(len(edges))[:, None], 3, 1)
    triangles = np.concatenate([w.triangles, fins])
    shading = np.concatenate([w.normal_triangles, rows])
    return replace(scene, water=Water("Finned", positions, triangles, normals, shading, build_twins(triangles)))


def test_fins_under_an_overhead_sun(every_method):
    """Upright fins on edges of flat water, three triangles to an edge, overhead sun

    Light passes along a fin and takes no notice: E = E_sun (1 - F(0)).
    """
    every_method(finned((0, 0, -1)), constant([transmitted(1.0)], SIDE), SIDE, 1e-5, 0.02)


def test_fins_under_a_slanted_sun(every_method):
    """The same fins under a slanted sun

    A fin bends the light that it takes, and shades the water behind it: photons, with the water in their way.
    """
    scene = finned((0.25, 0.1, -1))
    expected = trace(scene, SIDE, photons=30_000, water_shades=True, again=1e-3)
    every_method(scene, expected, SIDE, 1e-3, 0.1, right=(), sentences=(TWICE,))


def test_overhanging_waves(every_method):
    """Crests that overhang, under a sun nearly overhead

    The upper side of a crest sends light in; it leaves through the underside and enters again below. Photons tell the
    part of the light that enters for the first time; the rest must be said.
    """
    scene = replace(pool(flat, quads=2, direction=(0.05, 0.02, -1)), water=curl(0.3))
    expected = trace(scene, SIDE, photons=30_000, water_shades=True, again=1e-3)
    every_method(scene, expected, SIDE, 1e-3, 0.1, right=(), sentences=(TWICE,))


def test_steep_waves_that_do_not_overhang(every_method):
    """Crests that lean, but not over

    The same profile at half the lean is single-valued, and no light meets it twice: photons.
    """
    scene = replace(pool(flat, quads=2, direction=(0.05, 0.02, -1)), water=curl(0.1))
    expected = trace(scene, SIDE)
    every_method(scene, expected, SIDE)


def test_droplets(every_method):
    """Small closed droplets in the air over the waves

    A droplet's upper half sends light in and its lower half out again: that light meets the water twice, which is said
    where it is not followed. Under the droplets' shadows alone the map may be off.
    """
    scene = pool(five_sines, quads=48)
    expected = trace(scene, SIDE)
    scene = replace(scene, water=joined(scene.water, *droplets()))
    every_method(scene, expected, SIDE, 1e-3, 0.05, right=(), sentences=(TWICE,))
