"""How bright texels are, roughly."""

import numpy as np
import pytest
from waves import floor

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.trace.brightness import Brightness


def test_it_is_one_in_the_mean_and_falls_with_the_root_of_the_light():
    bright = Brightness([rasterise(floor(side=2.0), 32, padding=0)])
    i, j = (v.ravel() for v in np.meshgrid(np.arange(32) + 0.5, np.arange(32) + 0.5))
    bright.add(np.zeros(len(i), int), i, j, np.where(i < 16, 1.75, 0.25))
    left, right = bright.at(np.zeros(2, int), np.array([3.0, 30.0]), np.array([9.0, 9.0]))
    assert left == pytest.approx(np.sqrt(1.75 + 0.1)) and right == pytest.approx(np.sqrt(0.25 + 0.1))
