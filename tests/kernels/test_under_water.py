"""Above the water or below it, whichever way the mesh is wound."""

import numpy as np
import pytest
from waves import five_sines, mesh_water, water

from dapple.kernels.under_water import under_water


def turned(w):
    return mesh_water(w.positions, w.triangles[:, ::-1], -w.normals)


def closed():
    """A cube of water with 1 m edges round the origin, wound outwards."""
    corner = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return mesh_water(corner, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3), corner / np.linalg.norm(corner[0]))


@pytest.mark.parametrize("turn", [lambda w: w, turned], ids=["as it is", "turned"])
@pytest.mark.parametrize(
    ("point", "below"),
    [((0, 0, 2.5), False), ((0, 0, 0.5), True), ((9, 0, 2.0), False), ((9, 0, 1.0), True), ((0.3, 0.2, 1e3), False)],
)
def test_open_water(turn, point, below):
    assert under_water(turn(water(five_sines, 24)), np.array(point)) is below


@pytest.mark.parametrize("point", [(0, 0, 2.0), (3, 0, 0), (0.2, 0.1, -4.0)])
def test_outside_a_closed_body_is_not_under_water(point):
    assert not under_water(closed(), np.array(point))


def test_inside_a_closed_body_is_under_water():
    assert under_water(closed(), np.array([0.1, 0.2, 0.3]))
