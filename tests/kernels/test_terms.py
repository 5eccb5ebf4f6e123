"""Terms that are left out: what is left is what a scene without them has, and their work is not done."""

from dataclasses import replace

import numpy as np
import pytest
from waves import flat, floor, pool, quad, sun, turned, water

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Scene, Settings
from dapple.kernels.splat import ways
from dapple.kernels.terms import TERMS

METHODS = "photon_splat", "conic_walk"
BLEND = np.array([[-0.5, -0.5, 1.8], [0.5, -0.5, 1.8], [0.0, 0.6, 1.8]])


def image(scene, without=(), method="photon_splat", **settings):
    texels = [rasterise(receiver, 24) for receiver in scene.receivers]
    answer = solve(scene, texels, Settings(method, without=without, surface="mesh", **settings))
    return np.concatenate([i[..., :].ravel() for i in answer.images]), answer.diagnostics


def full():
    """The pool with all that can be left out by what is given."""
    light = replace(sun(), angle=0.05)
    shade = Occluder("Shade", BLEND, np.array([[0, 1, 2]]))
    return replace(pool(quads=24), lights=(light,), occluders=(shade,), sigma_a=np.array([0.4, 0.1, 0.05]))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("term", "less"),
    [
        ("absorption", {"sigma_a": np.zeros(3)}),
        ("disc", {"lights": (sun(),)}),
        ("occlusion", {"occluders": ()}),
    ],
)
def test_leaves_what_a_scene_without_it_has(method, term, less):
    scene = full()
    without, _ = image(scene, (term,), method)
    np.testing.assert_array_equal(without, image(replace(scene, **less), method=method)[0])
    assert np.abs(without - image(scene, method=method)[0]).max() > 1e-3


def test_dispersion_that_is_left_out_is_one_solve():
    scene = full()
    without, work = image(scene, ("dispersion",), dispersion=20.0)
    np.testing.assert_array_equal(without, image(scene)[0])
    assert np.ptp(work.etas) == 0


@pytest.mark.parametrize("method", METHODS)
def test_all_light_passes_without_fresnel(method):
    scene = Scene(water(flat, quads=8), (floor(),), (), (sun(),))
    values, work = image(scene, ("fresnel",), method)
    upright = -sun().direction[2]
    np.testing.assert_allclose(values, upright, rtol=1e-6)
    assert image(scene, method=method)[0].max() < 0.99 * upright
    assert not work.flux_lost.get("reflected", np.zeros(3)).any()


def test_a_wall_over_the_water_is_dark_without_reflection():
    wall = turned(quad("Wall", [[2.0, 2.0, 1.6], [-2.0, 2.0, 1.6], [-2.0, 2.0, 2.6], [2.0, 2.0, 2.6]]))
    scene = Scene(water(flat, quads=8), (floor(), wall), (), (sun((0.0, 0.6, -1.0)),))
    both, _ = image(scene)
    lower, _ = image(scene, ("reflection",))
    half = len(both) // 2
    assert both[half:].max() > 0
    assert not lower[half:].any()
    np.testing.assert_allclose(lower[:half], both[:half], rtol=1e-9)


def test_nothing_is_looked_for_that_meets_the_water_again(monkeypatch):
    def steep(x, y):
        k = 2 * np.pi / 0.8
        return 0.3 * np.sin(k * x), 0.3 * k * np.cos(k * x), 0 * y

    scene = Scene(water(steep, quads=48), (floor(),), (), (sun((1.0, 0.0, -1.0)),))
    _, work = image(scene)
    assert work.paths["rays_that_meet_the_water_again"] > 0
    monkeypatch.setattr(ways.Lit, "again", lambda lit: 0)
    values, work = image(scene, ("second_crossing", "reflection"))
    assert values.any()
    assert not {"second_meeting", "trapped", "shadowed_by_water"} & {k for k, w in work.flux_lost.items() if w.any()}


def test_no_surface_is_made_without_reconstruction():
    scene = pool(quads=24)
    texels = [rasterise(scene.receivers[0], 24)]
    answer = solve(scene, texels, Settings(tolerance=1e-4, without=("reconstruction",)))
    assert "as was asked for" in answer.diagnostics.surface
    assert "B-splines" in solve(scene, texels, Settings(tolerance=1e-4)).diagnostics.surface


def test_an_unknown_term_names_the_known():
    with pytest.raises(ValueError, match="caustics") as caught:
        solve(pool(quads=2), [], Settings(without=("caustics",)))
    assert all(term in str(caught.value) for term in TERMS)
