"""What stands round the water: occluders above and below it, and shores."""

import numpy as np
import pytest
from waves import OBLIQUE, calm, five_sines, flat, floor, pool, quad, transmitted, turned

from dapple.kernels.scene import Occluder
from dapple.tests.stability.photons import constant, trace

SIDE = 16
COS_I = 1 / np.sqrt(1 + 0.25**2 + 0.1**2)
STILL = COS_I * transmitted(COS_I)


def raft(side, z):
    """A square occluder at height z."""
    top = floor(side=side, z=z)
    return Occluder("Raft", top.positions, top.triangles)


def covered(low, high, resolution, side=4.0):
    """Share (resolution,) of each texel of a row of `side` m round the origin that lies between low and high."""
    edge = np.linspace(-side / 2, side / 2, resolution + 1)
    return np.clip(np.minimum(edge[1:], high) - np.maximum(edge[:-1], low), 0, None) / (side / resolution)


@pytest.mark.parametrize("z", [1.9, 1.501, 1.499, 0.7, 0.01], ids="{} m".format)
def test_occluders_over_and_under_flat_water(every_method, z):
    """A raft of 1 m at this height, the water's level at 1.5 m

    Parallel light casts a shadow of the raft's own size, moved by the slanted ray above the water and the refracted one
    below: by how much each texel is covered, in closed form.
    """
    scene = pool(flat, quads=48, side=12.0, occluders=[raft(1.0, z)])
    d = scene.lights[0].direction
    refracted = d / 1.333
    refracted[2] = -np.sqrt(1 - refracted[0] ** 2 - refracted[1] ** 2)
    above, below = max(z - 1.5, 0), min(z, 1.5)
    shift = -above * d[:2] / d[2] - below * refracted[:2] / refracted[2]
    over = np.outer(*(covered(s - 0.5, s + 0.5, SIDE) for s in shift[::-1]))
    every_method(scene, constant([STILL * (1 - over)], SIDE), SIDE, 1e-4, 0.1, right=("beams", "points"))


@pytest.mark.parametrize("z", [1.9, 0.7], ids=["floating", "sunken"])
@pytest.mark.parametrize("shape", [calm, five_sines], ids=["calm", "folds"])
def test_occluders_over_and_under_waves(every_method, shape, z):
    """A raft of 1 m over or under the waves

    Of several paths to a texel some are blocked and some are not: photons.
    """
    scene = pool(shape, quads=96, occluders=[raft(1.0, z)])
    expected = trace(scene, SIDE, photons=300_000)
    every_method(scene, expected, SIDE, 2e-3, 0.1)


def beach(low, high):
    """A plane bed that rises along x, from z = low to z = high over 4 m."""
    return quad("Beach", [[-2, -2, low], [2, -2, high], [2, 2, high], [-2, 2, low]])


def test_shore_where_the_depth_goes_to_zero(every_method):
    """A beach that rises through flat water, the water going on under the sand

    Down to the waterline E = E_sun (1 - F) cos i / cos t |t.n|, whatever the depth; the texels that it crosses get
    their wet part, and dry sand gets no light by way of the water.
    """
    scene = pool(flat, quads=48, side=12.0, receivers=[beach(0.9, 1.9)])
    d = scene.lights[0].direction
    t = d / 1.333
    t[2] = -np.sqrt(1 - t[0] ** 2 - t[1] ** 2)
    slope = np.array([-0.25, 0, 1]) / np.hypot(1, 0.25)
    wet = covered(-2, 0.4, SIDE)  # the bed meets the level of 1.5 m at x = 0.4
    expected = STILL / -t[2] * abs(t @ slope) * np.tile(wet, (SIDE, 1))
    every_method(scene, constant([expected], SIDE), SIDE, 1e-3, 0.05)


def test_shore_under_waves(every_method):
    """A beach under waves that run up to it

    Depth goes to zero under waves: photons, on the same sand.
    """
    scene = pool(calm, quads=96, receivers=[beach(1.0, 1.7)], direction=OBLIQUE)
    expected = trace(scene, SIDE, photons=300_000, seed=3)
    every_method(scene, expected, SIDE, 2e-3, 0.1, right=("beams", "points"))


def test_receiver_that_grazes_the_water(every_method):
    """A level bed a micrometre under flat water

    Depth does not matter under flat water: E = E_sun cos i (1 - F).
    """
    scene = pool(flat, quads=24, side=12.0, receivers=[floor(z=1.5 - 1e-6)])
    every_method(scene, constant([STILL], SIDE), SIDE, 1e-4, 0.05)


def test_walls_of_a_pool(every_method):
    """Four walls and a floor that close a pool, all receivers

    Corners where three receivers meet, walls that stand along the light: photons.
    """
    ends = np.array([[-2, -2], [2, -2], [2, 2], [-2, 2]], float)
    walls = [
        turned(quad(f"Wall {k}", [[*a, 0], [*b, 0], [*b, 2], [*a, 2]]))
        for k, (a, b) in enumerate(zip(ends, np.roll(ends, -1, axis=0), strict=True))
    ]
    scene = pool(calm, quads=48, side=4.0, receivers=[floor(), *walls])
    every_method(scene, trace(scene, 8), 8, 2e-3, 0.1)
