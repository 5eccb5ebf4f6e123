"""The references of the benchmarks, which share no code with the kernels, against closed forms and each other."""

import numpy as np
import pytest
import waves
from bench.reference_light import Floor, refract
from bench.reference_mesh import by_mesh
from bench.reference_waves import Sines, by_waves

DIRECTION = np.array(waves.OBLIQUE) / np.linalg.norm(waves.OBLIQUE)
POOL = Sines(waves.AMPLITUDE, waves.WAVELENGTH, waves.HEADING, waves.PHASE)
STILL = Sines(np.zeros(1), np.ones(1), np.zeros(1), np.zeros(1))
SQUARE = np.full(2, -2.4), np.full(2, 2.4)


def mesh_of(shape, quads):
    water = waves.water(shape, quads)
    return water.positions[water.triangles], water.normals[water.normal_triangles]


def error(image, reference):
    return ((image - reference) ** 2).mean() / (reference**2).mean()


def test_refraction_keeps_to_snell_and_fresnel():
    angle = np.radians(50)
    x, y, passed = refract(np.array([np.sin(angle), 0, -np.cos(angle)]), np.array([[0.0], [0], [3]]), 1.333)
    assert x[0] == pytest.approx(np.tan(np.arcsin(np.sin(angle) / 1.333)), rel=1e-12) and y[0] == 0
    assert passed[0] == pytest.approx(waves.transmitted(np.cos(angle)), rel=1e-12)


def test_still_water_lights_the_floor_evenly():
    expected = -DIRECTION[2] * waves.transmitted(-DIRECTION[2])
    by_cells = by_waves(STILL, 1.5, *SQUARE, DIRECTION, 1.333, Floor(), 32, 700)
    by_parts = by_mesh(*mesh_of(waves.flat, 8), DIRECTION, 1.333, Floor(), 32, 2)
    np.testing.assert_allclose(by_cells, expected, rtol=2e-4)
    np.testing.assert_allclose(by_parts, expected, rtol=1e-12)


def test_relief_stretches_the_texels_and_keeps_the_flux():
    relief = Sines(np.array([0.1]), np.array([1.3]), np.array([0.4]), np.array([0.2]))
    area = Floor(8.0, relief).texel_area(64)
    images = [by_mesh(*mesh_of(waves.five_sines, 32), DIRECTION, 1.333, Floor(8.0, f), 64, 2) for f in (None, relief)]
    assert area.sum() > 64.5
    assert (images[1] * area).sum() == pytest.approx(images[0].sum() * (8 / 64) ** 2, rel=1e-9)


def test_relief_is_met_where_the_ray_meets_it():
    relief = Sines(np.array([0.1]), np.array([1.3]), np.array([0.4]), np.array([0.2]))
    x, y = Floor(4.0, relief).land(*np.array([[0.3], [-0.2], [1.5]]), np.array([0.5]), np.array([0.3]))
    sunk = (x - 0.3) / 0.5
    assert 1.5 - sunk == pytest.approx(relief(x, y)[0], abs=1e-12)


def test_parts_and_cells_converge_to_one_picture():
    """Two codes: boxes from the waves themselves, clipped triangles from a mesh so fine that it is the waves."""
    true = by_waves(POOL, 1.5, *SQUARE, DIRECTION, 1.333, Floor(), 64, 1600)
    meshes = [by_mesh(*mesh_of(waves.five_sines, quads), DIRECTION, 1.333, Floor(), 64, 1) for quads in (128, 256, 512)]
    errors = [error(image, true) for image in meshes]
    assert errors[2] < 1e-4 and errors[2] < errors[1] / 4 < errors[0] / 16
    assert meshes[2].mean() == pytest.approx(true.mean(), rel=5e-5)


def test_finer_parts_converge():
    pieces = mesh_of(waves.five_sines, 32)
    images = [by_mesh(*pieces, DIRECTION, 1.333, Floor(), 64, parts) for parts in (2, 4, 8, 16)]
    errors = [error(image, images[-1]) for image in images[:-1]]
    assert errors[2] < 1e-6 and errors[2] < errors[1] / 4 < errors[0] / 16
