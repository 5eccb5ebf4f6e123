"""Suns: grazing, overhead, and square to the surface."""

from dataclasses import replace

import numpy as np
import pytest
from waves import calm, flat, grid, mesh_water, pool, transmitted

from dapple.tests.stability.constructions import strip
from dapple.tests.stability.judge import TWICE
from dapple.tests.stability.photons import constant, trace

SIDE = 16
ETA = 1.333


def down(elevation):
    """Direction of light from a sun `elevation` degrees above the horizon, off the axes."""
    e, heading = np.radians(elevation), 0.3
    return np.array([np.cos(e) * np.cos(heading), np.cos(e) * np.sin(heading), -np.sin(e)])


def swell(slope, length=1.6):
    """Waves along x of this greatest slope."""
    k = 2 * np.pi / length
    return lambda x, y: (slope / k * np.sin(k * x), slope * np.cos(k * x), np.zeros_like(x))


def tilted(slope, direction, quads=24, side=12.0):
    """A pool under a plane of water that rises by `slope` along a direction off the axes, and its answer.

    Parallel light stays parallel: what crosses the area A of the plane, |d.n| A, lands on |t.n| A / cos t of the floor.
    """
    x, y, triangles = grid(quads, side)
    n = np.array([-0.8 * slope, -0.6 * slope, 1.0])
    n /= np.linalg.norm(n)
    plane = np.stack([x, y, 1.5 + slope * (0.8 * x + 0.6 * y)], 1)
    scene = pool(flat, quads=2, direction=direction)
    d = scene.lights[0].direction
    cos_i = -d @ n
    cos_t = np.sqrt(1 - (1 - cos_i**2) / ETA**2)
    t = d / ETA + (cos_i / ETA - cos_t) * n
    scene = replace(scene, water=mesh_water(plane, triangles, np.tile(n, (len(plane), 1))))
    return scene, transmitted(cos_i) * cos_i / cos_t * abs(t[2])


@pytest.mark.parametrize("elevation", [30, 10, 5, 2])
def test_grazing_sun_on_flat_water(every_method, elevation):
    """Sun this many degrees high over flat water

    E = E_sun cos i (1 - F(i)) at every depth: flat water only turns and spreads the beam.
    """
    cos_i = np.sin(np.radians(elevation))
    scene = pool(flat, quads=8, direction=down(elevation), side=120.0)
    every_method(scene, constant([cos_i * transmitted(cos_i)], SIDE), SIDE, 1e-4, 0.05)


@pytest.mark.parametrize("elevation", [10, 5, 2])
def test_grazing_sun_on_waves_that_it_lights_wholly(every_method, elevation):
    """Sun this many degrees high over waves less steep than its rays

    Every facet faces the sun and none shades another, so photons traced one by one give the answer.
    """
    scene = pool(swell(0.3 * np.radians(elevation)), quads=96, direction=down(elevation), side=12.0)
    every_method(scene, trace(scene, SIDE), SIDE)


@pytest.mark.parametrize("elevation", [5, 2])
def test_grazing_sun_on_waves_that_shade_each_other(every_method, elevation):
    """Sun this many degrees high over waves three times as steep as its rays

    Crests shade the troughs behind them, and what one reflects the next lets in: photons that do all of it.
    """
    x = np.linspace(-6, 6, 97)
    height, slope, _ = swell(3 * np.radians(elevation))(x, x)
    profile = strip(np.stack([x, 1.5 + height], 1), np.stack([-slope, np.ones_like(x)], 1))
    scene = replace(pool(flat, quads=2, direction=down(elevation)), water=profile)
    expected = trace(scene, SIDE, photons=40_000, water_shades=True, again=1e-3)
    every_method(scene, expected, SIDE, 5e-3, 0.1, right=(), sentences=(TWICE,))


@pytest.mark.parametrize("lean", [0.0, 1e-9, 1e-6, 1e-3])
def test_flat_water_under_a_sun_nearly_overhead(every_method, lean):
    """Flat water, the sun off the zenith by this slope

    Every point is coplanar with light and normal, so the conic vanishes: E = E_sun cos i (1 - F(i)) all the same.
    """
    cos_i = 1 / np.hypot(1, lean)
    scene = pool(flat, quads=24, direction=(lean, 0, -1), side=12.0)
    every_method(scene, constant([cos_i * transmitted(cos_i)], SIDE), SIDE, 1e-5, 0.02)


@pytest.mark.parametrize("slope", [1e-9, 1e-6, 1e-3])
def test_water_tilted_by_little_under_an_overhead_sun(every_method, slope):
    """Plane water of this slope under an overhead sun

    Parallel light stays parallel: E = E_sun (1 - F) |d.n| |t.z| / |t.n|, next to that of level water.
    """
    scene, expected = tilted(slope, (0, 0, -1))
    every_method(scene, constant([expected], SIDE), SIDE, 1e-5, 0.02)


def test_water_square_to_the_light(every_method):
    """Plane water whose normal is parallel to the light

    Nothing bends: E = E_sun (1 - F(0)) cos of the floor's tilt to the light.
    """
    slope = 0.25
    scene, expected = tilted(slope, (0.8 * slope, 0.6 * slope, -1))
    assert expected == pytest.approx(transmitted(1.0) / np.hypot(1, slope), rel=1e-12)
    every_method(scene, constant([expected], SIDE), SIDE, 1e-5, 0.02)


def test_normals_parallel_to_the_light_at_vertices(every_method):
    """Waves with normals parallel to the light at crests, troughs and saddles

    There N x d vanishes and the curve has no direction; photons traced one by one need none.
    """

    def egg_box(x, y):
        k = 2 * np.pi / 0.8
        height = 1e-3 * np.cos(k * x) * np.cos(k * y)
        return height, -1e-3 * k * np.sin(k * x) * np.cos(k * y), -1e-3 * k * np.cos(k * x) * np.sin(k * y)

    scene = pool(egg_box, quads=96, direction=(0, 0, -1), side=4.8)
    expected = trace(scene, SIDE)
    assert np.ptp(expected.images[0]) > 0.05
    every_method(scene, expected, SIDE)


def test_calm_waves_as_usual(every_method):
    """Calm waves under a usual sun

    One path to every texel, nothing awkward: the photons' answer, and the measure for the rows that are awkward.
    """
    scene = pool(calm, quads=64)
    every_method(scene, trace(scene, SIDE), SIDE)
