"""The light of a cast by pilot, points and beams together, against many points alone: all of it, in its place."""

from functools import lru_cache

import numpy as np
import pytest
from casters import ball, no_water, slab
from waves import floor, sun

from dapple.kernels.casters import Caster, Glass
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Scene, Settings
from dapple.kernels.trace.cast import over_casters
from dapple.kernels.trace.spread import Spread

SIDE = 40


def rough_ball():
    """A ball with bumps of a few texels: its light is torn everywhere."""
    smooth = ball(0.8, (0, 0, 0), fine=32)
    rng = np.random.default_rng(7)
    a, b = rng.normal(size=(2, 24, 3))
    bumps = 0.01 * np.sin(12 * smooth.positions @ a.T + 6 * b[:, 0]).sum(1)
    positions = smooth.positions * (1 + bumps)[:, None] + [0, 0, 1.2]
    corners = positions[smooth.triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(facets))[:, None], 3, 1)
    return Caster("Rough", positions, smooth.triangles, facets, rows, Glass(1.5))


def _cast(caster, tolerance=1e-2, seed=0):
    direction = np.array([0.15, 0.1, -1])
    scene = Scene(no_water(), (floor(side=6.0, z=-0.5),), (), (sun(direction),), casters=(caster,))
    texels = [rasterise(receiver, SIDE) for receiver in scene.receivers]
    return over_casters(scene, texels, Settings(resolution=SIDE, tolerance=tolerance, seed=seed))[0]


@lru_cache
def _truth(name):
    """Flux (K,) by many points, followed as far."""
    flux, *_ = _cast(CASES[name]()).throw(2e5, np.random.default_rng(3))
    return flux[:, 0]


CASES = {
    "ball": lambda: ball(0.8, (0, 0, 1.2), fine=48),
    "slab": lambda: slab((-0.8, -0.6, 0.3), (0.7, 0.9, 0.8)),
    "rough": rough_ball,
}


@pytest.mark.parametrize(("name", "lost"), [("ball", 1e-3), ("slab", 4e-3), ("rough", 5e-3)])
def test_all_light_is_there_and_in_its_place(name, lost):
    flux, books, met, error = _cast(CASES[name]()).spread()
    truth = _truth(name)
    assert flux[:, 0].sum() == pytest.approx(truth.sum(), rel=lost)
    assert ((flux[:, 0] - truth) ** 2).sum() < 2e-2 * (truth**2).sum()
    assert 0 < error < 1 and met[0] > truth.sum() and min(watts.min() for watts in books.values()) > -1e-9


@pytest.mark.parametrize("name", CASES)
def test_what_comes_in_is_what_the_caster_stops(name):
    """Flux through the outline of the caster, torn behind it or not, and whether or not it comes to a receiver."""
    cast = _cast(CASES[name]())
    met, stopped = cast.spread()[2], cast.throw(2e5, np.random.default_rng(3))[2]
    assert met[0] == pytest.approx(stopped[0], rel=8e-3)


def test_seeds_agree_on_the_whole_of_torn_light():
    """What chance finds alone, and what hides between rays, weigh as much as they are: means over seeds are the truth,
    within their own scatter."""
    truth = _truth("rough").sum()
    sums = np.array([_cast(rough_ball(), seed=seed).spread()[0][:, 0].sum() for seed in range(4)])
    assert abs(sums.mean() / truth - 1) < 2e-3 + 3 * sums.std() / truth / np.sqrt(len(sums))


def test_a_stricter_tolerance_is_nearer():
    truth = _truth("ball")
    wrong = [((_cast(CASES["ball"](), t).spread()[0][:, 0] - truth) ** 2).sum() for t in (1.0, 1e-3)]
    assert wrong[1] < 0.5 * wrong[0]


def test_torn_light_is_landed_by_points_and_smooth_light_by_beams():
    kinds = {}
    for name in ("ball", "rough"):
        spread, landed = Spread(_cast(CASES[name]())), {}
        beam, more = spread._beam, spread._land_more

        def beams(pilot, sheet, tolerance, landed=landed, beam=beam):
            found = beam(pilot, sheet, tolerance)
            landed["beams"] = sheet.flux().sum()
            return found

        def points(pilot, landed=landed, spread=spread, more=more):
            before = len(spread._scatter._parts)
            more(pilot)
            landed["points"] = sum(part.flux.sum() for part in spread._scatter._parts[before:])

        spread._beam, spread._land_more = beams, points
        spread.result()
        kinds[name] = landed
    assert kinds["ball"]["points"] < 0.05 * kinds["ball"]["beams"]
    assert kinds["rough"]["points"] > 0.3 * kinds["rough"]["beams"]
