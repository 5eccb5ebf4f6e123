"""Where light sets out towards casters: cells and points that stay where they are while what is there moves."""

import numpy as np
import pytest
from casters import ball
from waves import sun

from dapple.kernels.scene import Point
from dapple.kernels.trace.entry import Entry, evenly, points

LIGHTS = {"sun": sun((0.3, 0.1, -1)), "lamp": Point("Lamp", np.array([0.1, -0.2, 1.5]), np.ones(3))}
WIDTH, SEED = 0.02, 3
GROUND = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])


def entry(light, by=0.0, width=WIDTH):
    """The Entry of two balls, of which one is moved."""
    still, moves = ball(0.2, (-0.4, 0, 0.3), fine=16), ball(0.15, (0.4 + by, 0.1, 0.2), fine=16)
    soup = np.concatenate([b.positions[b.triangles] for b in (still, moves)])
    return Entry(light, soup, np.concatenate([GROUND, soup.reshape(-1, 3)]), width)


def drawn(of, side=3, seed=SEED):
    """{column, row, of a stratum: its point}"""
    sides = np.full(of.place.shape[1], side)
    found = {}
    for _, stratum, m, _ in points(of.lit, sides, of.place, seed):
        found |= {tuple(s): tuple(p) for s, p in zip(stratum.T.tolist(), m.T.tolist(), strict=True)}
    return found


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_points_are_the_same_bit_for_bit_while_a_thing_moves_a_little(light):
    before, after = (drawn(entry(light, by)) for by in (0.0, 0.013))
    both = before.keys() & after.keys()
    assert len(both) > 0.9 * len(before) and before.keys() != after.keys()
    assert all(before[k] == after[k] for k in both)


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_points_are_apart_by_seed_and_by_how_many_there_are(light):
    first = drawn(entry(light))
    for other in (drawn(entry(light), seed=SEED + 1), drawn(entry(light), side=6)):
        assert not set(first.values()) & set(other.values())


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
def test_points_lie_evenly_in_their_strata(light):
    """Where in its stratum a point lies: any place is as likely, on both axes, and one axis tells nothing of the
    other."""
    of, inner = entry(light), []
    side = np.full(of.place.shape[1], 4)
    corner = of.lit.points[of.lit.triangles[::2]]
    for cell, stratum, m, _ in points(of.lit, side, of.place, SEED):
        a, b, c = np.moveaxis(corner[cell], 1, 0)
        local = np.stack([((m.T - a) * (b - a)).sum(1), ((m.T - a) * (c - b)).sum(1)])
        local /= np.stack([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1)])
        inner.append(local * 4 - (stratum - 4 * of.place[:, cell]))
    inner = np.concatenate(inner, 1)
    assert (inner > -1e-6).all() and (inner < 1 + 1e-6).all()
    noise = 4 / np.sqrt(inner.shape[1])
    np.testing.assert_allclose(inner.mean(1), 0.5, atol=noise * np.sqrt(1 / 12))
    np.testing.assert_allclose(np.cov(inner), np.eye(2) / 12, atol=noise / 6)


def test_cells_are_about_as_wide_as_asked_for():
    """Across a sun, as long as there are not too many or too few."""
    for width, expected in ((0.02, 0.02), (0.01, 0.01), (1e-4, 1.2 / 256), (1.0, 1.2 / 32)):
        lit = entry(LIGHTS["sun"], width=width).lit
        edge = np.linalg.norm(np.diff(lit.points[lit.triangles[0, :2]], axis=0))
        assert 0.7 * expected < edge <= 1.2 * expected


def test_the_area_of_points_is_that_of_the_cells():
    of = entry(LIGHTS["sun"])
    side = evenly(of.lit, 50_000)
    areas = [area for *_, area in points(of.lit, side, of.place, SEED)]
    assert sum(map(len, areas)) == pytest.approx(50_000, rel=0.2)
    assert sum(map(np.sum, areas)) == pytest.approx(of.lit.area.sum())
