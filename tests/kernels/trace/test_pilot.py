"""What becomes of the light that a few points find in the cells of an entry."""

import numpy as np
import pytest

from dapple.kernels.scene import Sun
from dapple.kernels.trace.entry import Entry
from dapple.kernels.trace.pilot import ALONG, BEAMS, PILOT, POINTS, Pilot

SIDE = 40
WORD = 0b111


@pytest.fixture(scope="module")
def entry():
    """About SIDE by SIDE cells under a vertical sun."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    soup = corners[[[0, 1, 2], [0, 2, 3]]]
    return Entry(Sun("Sun", np.array([0.0, 0, -1]), np.ones(3)), soup, np.append(corners, [[0, 0, 1.0]], 0), 1 / SIDE)


def _pilot(entry, hits, path=None, most=1.0, light=1.0, end=0):
    """The Pilot of one code, found in cells hits (n,) as often as they are, each on a path of its own or `path`."""
    cell = np.repeat(np.arange(len(hits)), hits)
    path = np.zeros(len(cell), int) if path is None else path[: len(cell)]
    code, light = np.full(len(cell), WORD), np.full(len(cell), light)
    return Pilot(code, path, np.full(len(cell), end), cell, light, np.ones(len(cell)), entry, most), cell


def _middle(entry):
    """The cell in the middle, and whether (n,) each lies within so many cells of it."""
    column, row = entry.place - entry.place.mean(1, keepdims=True).round()
    away = np.maximum(np.abs(column), np.abs(row))
    return int(away.argmin()), away


def test_smooth_light_is_landed_by_beams_from_two_cells_further_out(entry):
    _, away = _middle(entry)
    pilot, cell = _pilot(entry, np.where(away <= 4, ALONG**2, 0))
    assert (pilot.kind == BEAMS).all() and len(cell) == 81 * ALONG**2
    ((word, cells, torn),) = pilot.beams()
    assert word == WORD
    np.testing.assert_array_equal(cells, away <= 6)
    np.testing.assert_array_equal(
        torn, away == 5, err_msg="whole cells of one path hide nothing; those beside them may"
    )
    assert not pilot.points()[0].any() and pilot.error == 0


def test_an_outline_is_torn_and_still_the_beams(entry):
    """Light on one side of a line: the cells that it runs through hold it in part."""
    column = entry.place[0] - int(entry.place[0].mean())
    pilot, _ = _pilot(entry, np.select([column < 0, column == 0], [ALONG**2, 1], 0))
    ((_, cells, torn),) = pilot.beams()
    assert (pilot.kind == BEAMS).all() and cells[column <= 2].all() and not cells[column > 2].any()
    assert torn[np.abs(column) <= 1].all() and not torn[column < -1].any()


def test_what_is_found_alone_is_landed_as_found(entry):
    """Beams in its place would land what is there, and in all cells like it where chance found nothing, nothing."""
    middle, away = _middle(entry)
    hits = np.zeros(len(away), int)
    hits[middle] = 1
    pilot, _ = _pilot(entry, hits)
    assert (pilot.kind == PILOT).all()
    ((_, cells, torn),) = pilot.beams()
    np.testing.assert_array_equal(cells, (away > 0) & (away <= 2))
    assert torn[away == 1].all()


def test_what_becomes_of_a_cell_is_not_its_own_points_matter(entry):
    """Every cell, with what is round it by chance: beams or not whether its own points hit or miss."""
    rng, checked = np.random.default_rng(3), 0
    count = entry.place.shape[1]
    hits = np.where(rng.random(count) < 0.1, rng.integers(1, ALONG**2 + 1, count), 0)
    paths = rng.integers(0, 3, hits.sum() + ALONG**2)
    for own in rng.choice(count, 40, replace=False):
        landed = []
        for k in (0, 1, ALONG**2):
            hits[own] = k
            pilot, cell = _pilot(entry, hits, paths, most=1e9)
            beams = [cells[own] for _, cells, _ in pilot.beams()]
            landed.append((bool(beams and beams[0]), int(pilot.points()[0][own])))
            if k:
                assert (pilot.kind[cell == own] == BEAMS).all() == landed[-1][0]
                checked += 1
        assert len(set(landed)) == 1
        hits[own] = 0
    assert checked == 80


def test_rough_light_gets_points_as_many_as_its_error_asks_for(entry):
    """Paths that differ in every cell: the fewer errors may be left, the more points, and never fewer than found it."""
    _, away = _middle(entry)
    hits = np.where(away <= 5, ALONG**2, 0)
    path = np.arange(hits.sum())
    inside = away <= 4
    sides = []
    for most in (1e9, 100.0, 1.0):
        pilot, cell = _pilot(entry, hits, path, most)
        side, words, want = pilot.points()
        kind = pilot.kind[inside[cell]]
        assert (kind == (POINTS if most < 1e9 else PILOT)).all()
        if most < 1e9:
            assert words == [WORD] and (want[inside] == 1).all()
            assert 0.2 * most < pilot.error <= most
        sides.append(side[inside])
    assert not sides[0].any() and (sides[1] > ALONG).all() and (sides[2] > sides[1]).all()


def test_rough_light_that_comes_nowhere_is_booked_once(entry):
    """Torn, and on no receiver: the pilot's points tell how much it is, and no beams tell it again."""
    _, away = _middle(entry)
    hits = np.where(away <= 5, ALONG**2, 0)
    pilot, cell = _pilot(entry, hits, np.arange(hits.sum()), light=0.0)
    inside = away <= 4
    assert (pilot.kind[inside[cell]] == PILOT).all() and not pilot.points()[0].any()
    assert not any((cells & inside).any() for _, cells, _ in pilot.beams())


def test_no_light_needs_nothing(entry):
    pilot, _ = _pilot(entry, np.zeros(entry.place.shape[1], int))
    assert list(pilot.beams()) == [] and not pilot.points()[0].any() and len(pilot.kind) == 0
