"""Red, green and blue with an index each: where they land, and that their watts add up."""

from dataclasses import replace

import numpy as np
import pytest
from waves import OBLIQUE, five_sines, flat, floor, pool, sun, transmitted

from dapple.kernels.dispersion import etas
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings
from dapple.kernels.status import Status


def bake(scene, resolution=64, **settings):
    texels = [rasterise(r, resolution) for r in scene.receivers]
    return solve(scene, texels, Settings(resolution=resolution, tolerance=1e-3, surface="mesh", **settings))


def test_indices_of_water_are_those_that_are_measured():
    """At 20 degrees 1.3311, 1.3330, 1.3371 and 1.3403 at 656.3, 589.3, 486.1 and 434.0 nm, linear in lambda^-2."""
    lines, measured = np.array([656.3, 589.3, 486.1, 434.0]), [1.3311, 1.3330, 1.3371, 1.3403]
    expected = np.interp(np.array([611.4, 549.1, 464.2]) ** -2.0, lines**-2.0, measured)
    np.testing.assert_allclose(etas(1.333, 55.7), expected, atol=3e-4)


def test_impossible_numbers_and_none():
    red, green, blue = etas(1.5, 30.0)
    assert red < 1.5 < green < blue
    np.testing.assert_array_equal(etas(1.4, 0), [1.4] * 3)
    for abbe in (-1.0, 0.5):
        with pytest.raises(ValueError, match="dispersion must be 0 or"):
            etas(1.333, abbe)


@pytest.mark.parametrize("method", ["photon_splat", "conic_walk"])
def test_a_shadow_has_coloured_rims_as_wide_as_snell_says(method):
    """Water that ends over the floor: each colour's edge lies where its own refraction puts it."""
    direction = np.array([1.0, 0.0, -1.0]) / np.sqrt(2)
    scene = pool(flat, quads=16, side=2.0, direction=direction, receivers=[floor(side=6.0)])
    side = 256 if method == "photon_splat" else 96
    image = bake(scene, side, dispersion=2.0, method=method).images[0]
    lit = image.sum(0).T / image.max((0, 1))[:, None]  # (3, columns), in rows of texels
    weight = lit.sum(1, keepdims=True)
    centre = ((lit / weight) * ((np.arange(side) + 0.5) * 6 / side - 3)).sum(1)
    expected = 1.5 * np.tan(np.arcsin(np.sqrt(0.5) / etas(1.333, 2.0)))
    assert np.ptp(expected) > 0.14
    np.testing.assert_allclose(centre, expected, atol=2e-3 if method == "photon_splat" else 0.05)


def test_each_channel_is_the_solution_for_its_own_index():
    scene = replace(pool(five_sines, quads=48), lights=(sun(OBLIQUE, (1.0, 2.0, 3.0)),))
    whole = bake(scene, dispersion=20.0)
    for channel, eta in enumerate(etas(1.333, 20.0)):
        alone = bake(replace(scene, eta=eta))
        np.testing.assert_allclose(whole.images[0][..., channel], alone.images[0][..., channel], atol=1e-12)
    d = whole.diagnostics
    np.testing.assert_allclose(d.flux_received["Floor"] + sum(d.flux_lost.values()), d.flux_in, rtol=1e-9)
    np.testing.assert_allclose(d.etas, etas(1.333, 20.0))
    assert d.texels == {"lit": int((whole.status[0] == Status.LIT).sum())} and d.texels["lit"] == 64**2


def test_light_of_one_colour_is_solved_once():
    scene = replace(pool(five_sines, quads=24), lights=(sun(OBLIQUE, (0.0, 2.0, 0.0)),))
    green = bake(scene, dispersion=20.0)
    alone = bake(replace(scene, eta=etas(1.333, 20.0)[1]))
    np.testing.assert_array_equal(green.images[0], alone.images[0])
    assert green.diagnostics.paths == alone.diagnostics.paths


@pytest.mark.parametrize("abbe", [0.0, 20.0])
def test_matching_cycles_divides_the_images_by_eta_squared_and_no_watts(abbe):
    scene = pool(flat, quads=8, side=12.0, direction=(0, 0, -1))
    plain, matched = (bake(scene, 32, dispersion=abbe, match_cycles=m) for m in (False, True))
    indices = etas(1.333, abbe)
    expected = [transmitted(1.0, eta) / eta**2 for eta in indices]
    np.testing.assert_allclose(matched.images[0].mean((0, 1)), expected, rtol=1e-9)
    np.testing.assert_allclose(matched.diagnostics.map_scale, 1 / indices**2)
    np.testing.assert_array_equal(plain.diagnostics.map_scale, np.ones(3))
    for name, watts in plain.diagnostics.flux_received.items():
        np.testing.assert_array_equal(matched.diagnostics.flux_received[name], watts)
