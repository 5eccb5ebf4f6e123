"""Scales: far from the origin, a millimetre small, stretched."""

from dataclasses import replace

import numpy as np
import pytest
from waves import calm, five_sines, pool

from dapple.tests.stability.constructions import moved
from dapple.tests.stability.photons import trace

SIDE = 16


@pytest.mark.parametrize("shift", [1e3, 1e5])
def test_far_from_the_origin(every_method, shift):
    """The pool, this many metres from the origin on every axis

    Light does not know where the origin is: the photons of the pool at home.
    """
    scene = pool(calm, quads=64)
    expected = trace(scene, SIDE)
    every_method(moved(scene, lambda p: p + shift * np.array([1, -1, 1])), expected, SIDE)


@pytest.mark.parametrize("scale", [1e-3, 2.5e-4, 1e3], ids=["4 mm", "1 mm", "4 km"])
@pytest.mark.parametrize("shape", [calm, five_sines], ids=["calm", "folds"])
def test_small_and_large(every_method, shape, scale):
    """The pool with its floor this wide

    Refraction knows no lengths: the photons of the pool of 4 m.
    """
    scene = pool(shape, quads=64)
    expected = trace(scene, SIDE, photons=300_000)
    every_method(moved(scene, lambda p: scale * p), expected, SIDE, 2e-3, 0.1)


def test_stretched(every_method):
    """The pool stretched 10 times along x and pressed to a half along z

    Normals turn by the inverse transpose; long thin triangles cover long thin texels: photons.
    """
    scene = pool(calm, quads=64)
    n = scene.water.normals / np.array([10, 1, 0.5])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    stretched = moved(scene, lambda p: p * np.array([10, 1, 0.5]))
    scene = replace(stretched, water=replace(stretched.water, normals=n))
    every_method(scene, trace(scene, SIDE), SIDE)
