"""Colours through glass: a prism parts them by the closed form, each glass by its own Abbe number."""

from dataclasses import replace

import numpy as np
import pytest
from casters import SILVER, ball, no_water, prism, slab
from waves import flat, floor, quad, sun, water

from dapple.kernels.casters import Glass
from dapple.kernels.dispersion import etas, solve_channels
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Diagnostics, Occluder, Scene, Settings, Solution

APEX, INCIDENCE = np.radians(50.0), np.radians(40.0)


def through_a_prism(glass, dispersion, **settings):
    """The Diagnostics, and where (3,) along a wall 3 m from a prism the middle of each colour lies, as an angle."""
    out = np.array([-np.cos(APEX / 2), np.sin(APEX / 2)])  # of the face that the light meets, in x and z
    along = np.array([-out[1], out[0]])
    d = -np.cos(INCIDENCE) * out - np.sin(INCIDENCE) * along
    body = prism(APEX, side=0.2, length=0.4, material=glass)
    edge = [[3, -0.1, 0.4], [3, 0.1, 0.4], [3, 0.1, -2.6], [3, -0.1, -2.6]]
    low = -0.2 * np.cos(APEX / 2) - 1e-3
    base = quad("Base", [[x, y, low] for x, y in ((-0.085, -1), (0.085, -1), (0.085, 1), (-0.085, 1))])
    blind = Occluder("Base", base.positions, base.triangles)  # or light would come in from below
    scene = Scene(no_water(), (quad("Wall", edge),), (blind,), (sun((d[0], 0, d[1])),), casters=(body,))
    texels = [rasterise(scene.receivers[0], 128, padding=0)]
    answer = solve(scene, texels, Settings(resolution=128, dispersion=dispersion, bounces=2, **settings))
    light = answer.images[0].reshape(-1, 3)[texels[0].texel]
    return answer.diagnostics, np.arctan2(d[1], d[0]), texels[0].positions[:, 2], light


@pytest.mark.parametrize("own, of_all", [(0.0, 20.0), (20.0, 0.0), (20.0, 55.7)])
def test_a_prism_parts_colours_by_the_closed_form(own, of_all):
    """A sun's light leaves as parallel beams, one of each colour: their middles part by what the angles say, whatever
    the width. D = i + e - A, sin e = sin A sqrt(n^2 - sin^2 i) - cos A sin i."""
    _, start, height, light = through_a_prism(Glass(1.5, abbe=own), of_all, tolerance=1e-3)
    middle = (height[:, None] * light).sum(0) / light.sum(0)
    n = etas(1.5, 20.0)
    e = np.arcsin(np.sin(APEX) * np.sqrt(n**2 - np.sin(INCIDENCE) ** 2) - np.cos(APEX) * np.sin(INCIDENCE))
    turned = INCIDENCE + e - APEX
    assert np.ptp(turned) > np.radians(1.0)
    beam = np.array([_middle_of_beam(k, start) for k in n])
    np.testing.assert_allclose(middle, beam[:, 1] + (3 - beam[:, 0]) * np.tan(start - turned), atol=3e-3)


def _middle_of_beam(n, start):
    """Where (2,) the middle of the light that leaves a prism's far face leaves it, x and z, of all that fills it."""
    out = np.array([-np.cos(APEX / 2), np.sin(APEX / 2)])
    d = np.array([np.cos(start), np.sin(start)])
    ratio, cos_i = 1 / n, -(d @ out)
    inside = ratio * d + (ratio * cos_i - np.sqrt(1 - ratio**2 * (1 - cos_i**2))) * out
    near, far = (np.array([s * np.sin(APEX / 2), -np.cos(APEX / 2)]) * 0.2 for s in (-1, 1))
    reached = []  # along the far face, of light from the apex and from the foot of the near one
    for point in (np.zeros(2), near):
        along = np.linalg.solve(np.column_stack([far, -inside]), point)
        reached.append(np.clip(along[0], 0, 1))
    return far * np.mean(reached)


def test_equal_colours_are_solved_once_and_nothing_is_said_of_glass():
    plain, *_ = through_a_prism(Glass(1.5), 0.0, tolerance=0.1)
    apart, *_ = through_a_prism(Glass(1.5), 30.0, tolerance=0.1)
    assert apart.paths["beams"] == 3 * plain.paths["beams"]
    assert not any("dispersion" in sentence for sentence in apart.left_out)


def given(scene, dispersion):
    """What the method is given, one Scene a solve: (indices of water and glass, lit channels)."""
    seen = []

    def method(scene, texels, settings):
        glass = [c.material.eta for c in scene.casters if isinstance(c.material, Glass)]
        seen.append(((scene.eta, *glass), tuple(scene.lights[0].irradiance > 0)))
        return solve(scene, texels, replace(settings, method="photon_splat", tolerance=1.0, dispersion=0.0))

    texels = [rasterise(r, 8, padding=0) for r in scene.receivers]
    solve_channels(method, scene, texels, Settings(resolution=8, dispersion=dispersion))
    return seen


def test_each_medium_has_its_own_indices():
    casters = ball(0.2, (0, 0, 0.5), 8, Glass(1.5)), slab((-1, -1, 0), (-0.5, 1, 0.5), Glass(1.6, abbe=30.0))
    casters += (ball(0.1, (1, 0, 0.5), 8, SILVER),)
    scene = Scene(water(flat, 2, 4.0), (floor(),), (), (sun(),), casters=casters)
    rows = np.column_stack([etas(1.333, 55.7), etas(1.5, 55.7), etas(1.6, 30.0)])
    np.testing.assert_allclose([row for row, _ in given(scene, 55.7)], rows)
    assert [lit.index(True) for _, lit in given(scene, 55.7)] == [0, 1, 2]
    rows = np.column_stack([np.full(3, 1.333), np.full(3, 1.5), etas(1.6, 30.0)])
    np.testing.assert_allclose([row for row, _ in given(scene, 0.0)], rows)


def test_mirrors_and_bubbles_part_no_colours():
    """Air has the index 1 in every colour; water that is not there has none."""
    casters = ball(0.2, (0, 0, 0.5), 8, Glass(1.0)), ball(0.1, (1, 0, 0.5), 8, SILVER)
    assert len(given(Scene(no_water(), (floor(),), (), (sun(),), casters=casters), 20.0)) == 1


def test_what_every_colour_leaves_out_is_said_once():
    """Though each loses another share of its light to it."""

    def method(scene, texels, settings):
        share = 0.1 * scene.casters[0].material.eta
        return Solution(
            (), (), Diagnostics("m", "r", left_out=[f"light that goes astray: {share:.1%} of all", "lamps"])
        )

    scene = Scene(no_water(), (), (), (sun(),), casters=(ball(0.2, fine=8),))
    said = solve_channels(method, scene, [], Settings(dispersion=5.0)).diagnostics.left_out
    assert [s[:23] for s in said] == ["light that goes astray:", "lamps"]
