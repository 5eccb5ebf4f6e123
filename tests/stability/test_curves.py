"""Curves and folds: the conic where it is awkward, and light where it crowds."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from waves import OBLIQUE, five_sines, flat, floor, mesh_water, pool, quad

from dapple.tests.stability.photons import trace

SIDE = 16
FIXTURES = json.loads((Path(__file__).parents[1] / "kernels" / "walk" / "conic_fixtures.json").read_text())


def fixture_scene(name):
    """The fixture's triangle as the only water, over a receiver of 16 x 16 mm round its point."""
    data = FIXTURES[name]
    normals = np.array(data["n"])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    x, y, z = data["P"]
    half = 8e-3
    corners = [[x - half, y - half, z], [x + half, y - half, z], [x + half, y + half, z], [x - half, y + half, z]]
    scene = pool(flat, quads=2, direction=OBLIQUE, receivers=[quad("Patch", corners)], eta=1.33)
    return replace(scene, water=mesh_water(np.array(data["V"]), np.array([[0, 1, 2]]), normals))


@pytest.mark.parametrize("name", FIXTURES)
def test_conics_in_one_triangle(every_method, name):
    """One triangle, one point with known roots

    The patch round the point gets the light of each root; photons through the triangle.
    """
    scene = fixture_scene(name)
    expected = trace(scene, 8, photons=600_000)
    assert expected.images[0].max() > 0
    every_method(scene, expected, 8, 5e-3, 0.1)


def ripples(slope, length=0.8):
    """Waves along x only, of this greatest slope."""
    k = 2 * np.pi / length
    return lambda x, y: (slope / k * np.cos(k * x), -slope * np.sin(k * x), np.zeros_like(x))


@pytest.mark.parametrize("slope", [0.02, 0.2], ids=["one path", "folds"])
def test_curves_through_vertices_and_along_edges(every_method, slope):
    """Waves along the mesh's edges, the sun in their plane, texel centres under vertices

    Every curve is a row of edges and meets a vertex at every step; photons know no curves.
    """
    scene = pool(ripples(slope), quads=96, direction=(0.25, 0, -1), side=12.0, receivers=[floor(side=2.0)])
    every_method(scene, trace(scene, SIDE), SIDE, 2e-3, 0.1)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_folds(every_method, scale):
    """The pool's five waves, and twice as high

    The map folds and light crowds along the folds without limit; the mean over a texel is finite: photons.
    """
    scene = pool(lambda x, y: five_sines(x, y, scale), quads=96)
    every_method(scene, trace(scene, SIDE, photons=500_000), SIDE, 2e-3, 0.1)


def test_cusps(every_method):
    """Waves like an egg box, overhead sun, twice as deep as they focus

    Folds meet in cusps above each other, on lines of symmetry of waves, mesh and texels: photons.
    """

    def egg_box(x, y):
        k, height = 2 * np.pi / 0.8, 0.02
        return (
            height * np.cos(k * x) * np.cos(k * y),
            -height * k * np.sin(k * x) * np.cos(k * y),
            -height * k * np.cos(k * x) * np.sin(k * y),
        )

    scene = pool(egg_box, quads=96, direction=(0, 0, -1), side=4.8)
    expected = trace(scene, SIDE, photons=500_000)
    every_method(scene, expected, SIDE, 2e-3, 0.1)


def test_focus_in_one_texel(every_method):
    """A round crest of 0.2 m whose focus lies in one texel

    Its radius is a quarter of the depth, so all that it passes meets in the middle texel: its flux over the texel's
    area, by photons; every other texel is dark.
    """
    radius = 1.5 / 4.003

    def crest(x, y):
        drop = radius - np.sqrt(radius**2 - x**2 - y**2)
        lean = np.sqrt(radius**2 - x**2 - y**2)
        return -drop, -x / lean, -y / lean

    scene = pool(crest, quads=32, direction=(0, 0, -1), side=0.2)
    side = 17
    expected = trace(scene, side)
    middle = expected.images[0][side // 2, side // 2]
    assert middle == pytest.approx(0.98 * 0.04 / (4 / side) ** 2, rel=5e-3) and np.count_nonzero(expected.images) == 1
    every_method(scene, expected, side, 1e-3, 0.02)
