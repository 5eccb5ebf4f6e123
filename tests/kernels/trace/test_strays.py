"""What goes astray between media is counted and said, by the name of what it came out of."""

import numpy as np
import pytest
from casters import ball, inside_out, no_water, patch, slab
from waves import floor, sun

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Scene, Settings

SPAN = np.linspace(-0.3, 0.3, 7)


def said(*casters, points=False, beside=False):
    """What is left out of the light of a sun over casters, and the share of all that the sentences name."""
    receivers = (floor(side=0.2 if beside else 2.0),)
    scene = Scene(no_water(), receivers, (), (sun((0, 0, -1)),), casters=casters)
    texels = [rasterise(r, 16, padding=0) for r in receivers]
    answer = solve(scene, texels, Settings(resolution=16, points=points, tolerance=0.1))
    return " ".join(s for s in answer.diagnostics.left_out if "the right way" in s)


def sheet(up):
    return patch(lambda u, v: (u, v, 0.5 + 0 * u), lambda u, v: (0 * u, 0 * u, up + 0 * u), SPAN, SPAN, name="Pane")


@pytest.mark.parametrize("points", [False, True])
def test_closed_glass_sends_none_astray(points):
    assert said(ball(0.3, (0, 0, 0.5), fine=48), slab((-0.2, -0.2, 0.4), (0.1, 0.1, 0.9)), points=points) == ""


@pytest.mark.parametrize("points", [False, True])
def test_a_single_sheet_is_said_from_either_side(points):
    assert "comes out of 'Pane' though it never went in" in said(sheet(-1), points=points)
    assert "goes into glass and never comes out" in said(sheet(1), points=points, beside=True)


def test_a_ball_inside_out_is_said():
    assert "100.0% of the light over casters, which comes out of 'Ball'" in said(inside_out(ball(0.3, (0, 0, 0.5))))


def test_faces_in_one_place_are_said():
    """A block on a block: light leaves the one, or meets the other first, and misses the other face."""
    stacked = slab((-0.3, -0.3, 0.5), (0.3, 0.3, 0.7)), slab((-0.3, -0.3, 0.7), (0.3, 0.3, 0.9), name="Upper")
    words = said(*stacked, beside=True)
    assert "though it never went in" in words or "never comes out" in words
