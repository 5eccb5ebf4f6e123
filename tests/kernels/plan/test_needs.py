"""What each term changes, against closed forms and scenes that lack it."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball, no_water
from waves import flat, floor, pool, quad, sun, transmitted, turned, water

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.plan.needs import needs
from dapple.kernels.scene import Scene, Settings


def of(scene, **settings):
    own = [rasterise(receiver, 24) for receiver in scene.receivers]
    return {need.term: need for need in needs(scene, own, Settings(**settings), repeats=1)}


def test_still_clear_water_needs_fresnel_alone():
    direction = (0.3, 0.0, -1.0)
    found = of(Scene(water(flat, quads=8), (floor(),), (), (sun(direction),)))
    cos_i = -sun(direction).direction[2]
    assert found["fresnel"].change == pytest.approx((1 / transmitted(cos_i) - 1) ** 2, rel=1e-6)
    assert set(found) == {"fresnel", "occlusion", "second_crossing", "reflection", "reconstruction"}
    assert all(need.change < 1e-12 for term, need in found.items() if term != "fresnel")
    assert all(need.of > 0 for need in found.values())


def test_absorption_is_what_it_takes_away():
    scene = Scene(water(flat, quads=8), (floor(),), (), (sun((0, 0, -1)),), sigma_a=np.full(3, 0.2))
    assert of(scene)["absorption"].change == pytest.approx((np.exp(0.2 * 1.5) - 1) ** 2, rel=1e-6)


def test_where_there_is_no_water_nothing_of_it_is_asked_for():
    glass = (ball(0.3, (0.0, 0.0, 1.0), fine=8),)
    scene = Scene(no_water(), (floor(),), (), (replace(sun(), angle=0.01),), casters=glass)
    assert set(of(scene)) == {"disc"}
    assert set(of(replace(scene, occluders=(quad("Lid", [[5.0, 5.0, 2.0], [6, 5, 2], [6, 6, 2], [5, 6, 2]]),)))) == {
        "disc",
        "occlusion",
    }


def test_a_wall_that_has_all_its_light_by_reflection_needs_it():
    wall = turned(quad("Wall", [[2.0, 2.0, 1.6], [-2.0, 2.0, 1.6], [-2.0, 2.0, 2.6], [2.0, 2.0, 2.6]]))
    found = of(Scene(water(flat, quads=8), (floor(), wall), (), (sun((0.0, 0.6, -1.0)),)))
    assert found["reflection"].worst == pytest.approx(1.0)
    assert found["reflection"].change < 1e-2


def test_waves_need_the_surface_and_a_wide_sun_its_disc():
    wide = replace(pool(quads=48), lights=(replace(sun(), angle=0.2),))
    found = of(wide, tolerance=1e-3, dispersion=55.7)
    assert found["reconstruction"].change > 1e-4
    assert found["disc"].change > 1e-3
    assert 0 < found["dispersion"].change < 0.5
