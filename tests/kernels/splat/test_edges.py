"""The water's edges, against one triangle's sides at a time."""

import numpy as np
import pytest

from dapple.kernels.halfedges import build_twins
from dapple.kernels.splat.edges import Edges

FAN = np.array([[0, 1, 2], [0, 2, 3], [0, 4, 3], [2, 1, 5]])  # the third is wound against the second
FIN = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])  # three triangles along one edge


def outlines(triangles, density, smooth):
    """{(tail, head) nodes, tail first: density to the left less that to the right}, summed side by side."""
    found = {}
    for t, own in enumerate(density):
        for k in range(3):
            a, b = (3 * t + k, 3 * t + (k + 1) % 3) if not smooth else (triangles[t, k], triangles[t, (k + 1) % 3])
            sign = 1 if a < b else -1
            found[min(a, b), max(a, b)] = found.get((min(a, b), max(a, b)), 0.0) + sign * own
    return found


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("triangles", [FAN, FIN], ids=["fan", "fin"])
def test_edges_part_what_lies_on_both_sides(triangles, smooth):
    density = np.array([1.0, 0.3, 0.7, 0.2])[: len(triangles)]
    edges = Edges.of(triangles, build_twins(triangles), smooth)
    found = {}
    for a, b, value in zip(edges.tail, edges.head, edges.differences(density[None])[0], strict=True):
        sign = 1 if a < b else -1
        found[min(a, b), max(a, b)] = found.get((min(a, b), max(a, b)), 0.0) + sign * value
    wanted = outlines(triangles, density, smooth)
    assert found.keys() == wanted.keys()
    for key, value in wanted.items():
        assert found[key] == pytest.approx(value, abs=1e-15)


def test_triangles_know_their_edges_and_share_them():
    edges = Edges.of(FAN, build_twins(FAN), True)
    for t, corners in enumerate(FAN):
        for k in range(3):
            ends = {edges.tail[edges.edge[k, t]], edges.head[edges.edge[k, t]]}
            assert ends == {corners[k], corners[(k + 1) % 3]}
    assert len(edges.tail) == 12 - 3  # three of twelve sides are shared
