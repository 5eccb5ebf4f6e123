"""Receivers that glass stands on are moved back from it, and wider; all others stay as they are."""

import numpy as np
import pytest
from casters import SILVER, ball, inside_out, no_water, slab
from waves import floor, quad, turned

from dapple.kernels.scene import Receiver, Scene
from dapple.kernels.trace.receded import receded

OFF = 1e-5


def _moved(*receivers, casters):
    return receded(Scene(no_water(), receivers, (), (), casters=casters), OFF)


@pytest.mark.parametrize(
    "place", [(-0.5, 0.5), (-1.4, -0.4), (0.8, 1.8), (-9, 12)], ids=["on it", "corner", "hangs over", "larger"]
)
def test_a_table_that_glass_stands_on_sinks_and_widens(place):
    low, high = place
    block = slab((low, low, 0.5), (high, high, 1.0))
    below = floor(side=2.0, z=-1.0)
    table, other = _moved(floor(side=2.0, z=0.5), below, casters=(block,))
    assert other is below
    np.testing.assert_allclose(table.positions[:, 2], 0.5 - 2 * OFF, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.abs(table.positions[:, :2]), 1 + 2 * OFF, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "caster",
    [
        slab((-0.5, -0.5, 0.5), (0.5, 0.5, 1.0), SILVER),
        slab((-0.5, -0.5, 0.501), (0.5, 0.5, 1.0)),
        slab((-0.5, -0.5, 0.4), (0.5, 0.5, 1.0)),
        slab((-0.5, -0.5, 0.0), (0.5, 0.5, 0.5)),
        ball(0.5, (0, 0, 2), fine=8),
    ],
    ids=["metal", "above", "through", "below", "away"],
)
def test_what_no_glass_stands_on_stays(caster):
    table = floor(side=2.0, z=0.5)
    assert _moved(table, casters=(caster,)) == (table,)


def test_a_pane_on_a_wall_and_a_box_that_glass_lies_in():
    wall = quad("Wall", [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]])
    pane = slab((0.8, -0.5, -0.5), (1, 0.5, 0.5))
    for front in (wall, turned(wall)):
        (found,) = _moved(front, casters=(pane,))
        seen = np.cross(
            *(front.positions[front.triangles[0, k]] - front.positions[front.triangles[0, 0]] for k in (1, 2))
        )
        assert found.positions[0, 0] - 1 == pytest.approx(2 * OFF if seen[0] < 0 else 0, abs=1e-12)
    box = inside_out(slab((-1, -1, -1), (1, 1, 1)))
    box = Receiver("Box", box.positions, box.triangles, np.zeros((12, 3, 2)))
    (found,) = _moved(box, casters=(slab((-0.5, -0.5, -1), (0.5, 0.5, 0)),))
    grown = np.abs(found.positions) - 1
    assert grown.min() > 2 * OFF - 1e-12 and grown.max() < 5 * OFF


def test_what_has_no_area_does_no_harm():
    flat = Receiver("Flat", np.zeros((3, 3)), np.array([[0, 1, 2]]), np.zeros((1, 3, 2)))
    block = slab((-0.5, -0.5, 0.5), (0.5, 0.5, 1.0))
    found, table = _moved(flat, floor(side=2.0, z=0.5), casters=(block,))
    assert found is flat and table.positions[0, 2] < 0.5
