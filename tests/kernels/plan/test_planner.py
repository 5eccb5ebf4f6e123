"""The planner's choices, their reasons, and that frames of an animation do not depend on each other."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball
from waves import AMPLITUDE, HEADING, PHASE, WAVELENGTH, faceted, grid, pool, quad, shaded_smooth, sun

from dapple.kernels.anchor import Anchor, Kept
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import prepare, solve
from dapple.kernels.plan.planner import FLAT, MESH, SMOOTH, planned
from dapple.kernels.scene import Occluder, Point, Settings
from dapple.kernels.surface import splines
from dapple.kernels.surface.fit import fit_tolerance
from dapple.kernels.surface.smoothing import Smoothing

SIDE = 48
KNOWN = Smoothing(0.002, 1.0)


def meshed(height, quads=64, side=4.8, level=1.5):
    """The pool's floor under waves `height(x, y)` [m] with Blender's normals."""
    x, y, triangles = grid(quads, side)
    return replace(pool(quads=2), water=shaded_smooth(np.stack([x, y, level + height(x, y)], 1), triangles))


def sines(x, y, scale):
    """Height and slopes of the pool's three longest waves, times `scale`."""
    k = 2 * np.pi / WAVELENGTH[:3] * np.array([np.cos(HEADING[:3]), np.sin(HEADING[:3])])
    phase = x[..., None] * k[0] + y[..., None] * k[1] + PHASE[:3]
    slopes = scale * AMPLITUDE[:3] * np.cos(phase) * k[:, None]
    return (scale * AMPLITUDE[:3] * np.sin(phase)).sum(-1), *slopes.sum(-1)


def waves(scale):
    return meshed(lambda x, y: sines(x, y, scale)[0])


def texels_of(scene, side=SIDE):
    return [rasterise(receiver, side) for receiver in scene.receivers]


def plan_of(scene, tolerance=1e-2, anchor=None, side=SIDE, **settings):
    return planned(scene, texels_of(scene, side), Settings(tolerance=tolerance, **settings), KNOWN, anchor)


def off(image, other):
    return float(((image - other) ** 2).mean() / (other**2).mean())


@pytest.mark.parametrize(("scale", "kind"), [(0.0, FLAT), (0.1, FLAT), (0.4, MESH), (2.0, SMOOTH), (4.0, SMOOTH)])
def test_from_still_to_stormy(scale, kind):
    assert plan_of(waves(scale), side=128).choice.kind == kind


def test_a_tighter_tolerance_takes_more():
    kinds = [plan_of(waves(0.2), tolerance, side=128).choice.kind for tolerance in (5e-2, 1e-3, 1e-6)]
    assert kinds == [FLAT, MESH, SMOOTH]


@pytest.mark.parametrize("scale", [0.1, 0.4, 2.5])
@pytest.mark.parametrize("tolerance", [5e-2, 1e-2, 1e-3])
def test_what_is_chosen_meets_the_tolerance(scale, tolerance):
    """Against a mesh of 16 times the triangles with the waves' own normals."""
    scene = waves(scale)
    own = texels_of(scene)
    answer = solve(scene, own, Settings(tolerance=tolerance), Kept(Anchor(KNOWN)))
    fine = pool(lambda x, y: sines(x, y, scale), quads=256)
    true = solve(fine, own, Settings("photon_splat", 1e-5, surface="mesh")).images[0]
    assert off(answer.images[0], true) <= tolerance
    assert answer.diagnostics.estimated_error <= tolerance


def test_a_draft_takes_no_more_than_one_part_a_triangle():
    scene = waves(2.0)
    own = texels_of(scene, 128)
    answer = solve(scene, own, Settings(tolerance=5e-2), Kept(Anchor(KNOWN)))
    fine = pool(lambda x, y: sines(x, y, 2.0), quads=256)
    true = solve(fine, own, Settings("photon_splat", 1e-5, surface="mesh")).images[0]
    assert "1 x 1 parts" in answer.diagnostics.surface
    assert off(answer.images[0], true) <= 5e-2


def test_splines_are_fitted_so_finely_that_it_does_not_show(monkeypatch):
    scene, settings = waves(2.0), Settings("photon_splat", tolerance=5e-2)
    own = texels_of(scene, 128)
    loose = solve(scene, own, settings, Kept(Anchor(KNOWN))).images[0]
    monkeypatch.setattr(splines, "fit_tolerance", lambda _: fit_tolerance(0.0))
    fine = solve(scene, own, settings, Kept(Anchor(KNOWN))).images[0]
    assert 0 < off(loose, fine) < 2e-3 * settings.tolerance


def test_no_light_is_lost_on_stormy_water():
    scene = waves(3.0)
    answer = solve(scene, texels_of(scene), Settings(tolerance=5e-2), Kept(Anchor(KNOWN)))
    true = solve(scene, texels_of(scene), Settings("photon_splat", 1e-4), Kept(Anchor(KNOWN)))
    assert answer.images[0].mean() == pytest.approx(true.images[0].mean(), rel=5e-3)


def droplets(scene):
    """The water with a second, small sheet of it over the first."""
    x, y, triangles = grid(8, 0.5)
    above = np.stack([x, y, np.full_like(x, 1.7)], 1)
    water = scene.water
    both = np.concatenate([water.positions, above]), np.concatenate([water.triangles, triangles + len(water.positions)])
    return replace(scene, water=shaded_smooth(*both))


def under_a_near_lamp(scene):
    return replace(scene, lights=(Point("Lamp", np.array([0.0, 0.0, 2.5]), np.ones(3)),))


def with_a_caster(scene):
    return replace(scene, casters=(ball(0.2, (0.0, 0.0, 2.0), fine=8),))


def shaded_flat(scene):
    return replace(scene, water=faceted(scene.water))


@pytest.mark.parametrize("spoil", [droplets, under_a_near_lamp, with_a_caster, shaded_flat])
def test_still_water_is_for_one_gentle_sheet_under_far_lights(spoil):
    scene = meshed(lambda x, y: 0 * x)
    assert plan_of(scene).choice.kind == FLAT
    assert plan_of(spoil(scene)).choice.method == "photon_splat"


def walled(scale, above=0.05, angle=0.0):
    """The bed of a basin under waves that go on into its walls, which rise `above` [m] over the water."""

    def wall(k):
        corners = np.array([[1.5, -1.5, -0.1], [1.5, 1.5, -0.1], [1.5, 1.5, 1.5 + above], [1.5, -1.5, 1.5 + above]])
        turn = np.array([[np.cos(k), -np.sin(k), 0], [np.sin(k), np.cos(k), 0], [0, 0, 1]])
        return Occluder("Wall", corners @ turn.T, np.array([[0, 1, 2], [0, 2, 3]]))

    scene = meshed(lambda x, y: sines(x, y, scale)[0], side=3.2)
    light = replace(sun((0.45, 0.25, -1.0)), angle=angle)
    walls = tuple(wall(0.3 + k) for k in np.pi / 2 * np.arange(4))  # askew: an edge along rows has one chance only
    bed = quad("Bed", [[-1.5, -1.5, 0], [1.5, -1.5, 0], [1.5, 1.5, 0], [-1.5, 1.5, 0]])
    return replace(scene, receivers=(bed,), occluders=walls, lights=(light,))


@pytest.mark.parametrize(("scale", "above", "side"), [(0.0, 0.05, 96), (0.1, 0.05, 64), (0.1, 0.8, 128)])
def test_still_water_within_walls_is_taken_and_its_shade_is_kept(scale, above, side):
    """Walls shade a fifth of the bed; what that errs, with the waves, is predicted within a factor of 2.5."""
    scene = walled(scale, above, np.radians(0.53))
    plan = plan_of(scene, 1e-1, side=side)
    assert plan.choice.kind == FLAT and "occlusion" not in plan.choice.without
    own = texels_of(scene, side)
    true = solve(scene, own, Settings("photon_splat", 1e-5, surface="mesh")).images[0]
    error = off(solve(scene, own, plan.settings(Settings())).images[0], true)
    assert 0.1 < np.mean(true == 0) < 0.6
    assert error / 2 < plan.choice.error < 2.5 * error


def test_wide_penumbrae_of_high_walls_are_no_job_for_still_water():
    low, high = (plan_of(walled(0.0, above, np.radians(8.0)), 1e-2, side=128) for above in (0.05, 2.5))
    assert high.choice.kind != FLAT and low.measures["waves"] < high.measures["waves"] / 2


def test_a_mesh_asked_for_is_no_term_dropped():
    plan = plan_of(waves(2.0), surface="mesh", side=128)
    assert plan.choice.without == () and plan.choice.error == 0


def test_a_narrow_sun_is_a_point_and_a_wide_one_is_not():
    def under(degrees):
        scene = waves(2.0)
        return replace(scene, lights=(replace(sun(), angle=np.radians(degrees)),))

    assert "disc" in plan_of(under(0.02)).choice.without
    assert "disc" not in plan_of(under(2.0), side=192).choice.without
    assert "disc" not in plan_of(under(0.0)).choice.without  # nothing to leave out


def test_reasons_are_sentences_with_numbers():
    for scale, word in ((0.1, "waves are low"), (0.4, "mesh is fine enough"), (2.5, "bright lines")):
        scene = waves(scale)
        work = solve(scene, texels_of(scene, 128), Settings(), Kept(Anchor(KNOWN))).diagnostics
        assert word in work.reason and "expected error" in work.reason and "s a frame" in work.reason
        assert work.plan["choice"] in (FLAT, MESH, SMOOTH) and work.plan["choices"]


def test_a_reason_tells_no_time_that_is_not_known():
    scene = with_a_caster(waves(1.0))
    work = solve(scene, texels_of(scene, 32), Settings(), Kept(Anchor(KNOWN))).diagnostics
    assert "expected error" in work.reason and "s a frame" not in work.reason


def test_the_anchor_is_kept_while_it_will_do():
    """Where rays take most of the time, the smooth water costs less than twice its mesh."""

    def in_two_halves(scale):
        corners = np.array([[-2.0, -2.0, 0.0], [0.0, -2.0, 0.0], [0.0, 2.0, 0.0], [-2.0, 2.0, 0.0]])
        halves = quad("West", corners), quad("East", corners + np.array([2.0, 0.0, 0.0]))
        return replace(waves(scale), receivers=halves)

    rough, gentle, still = (plan_of(in_two_halves(scale), side=128) for scale in (2.5, 0.5, 0.1))
    assert (rough.choice.kind, gentle.choice.kind, still.choice.kind) == (SMOOTH, MESH, FLAT)
    assert plan_of(in_two_halves(0.5), anchor=rough, side=128).choice.kind == SMOOTH
    assert plan_of(in_two_halves(0.1), anchor=rough, side=128).choice.kind == FLAT  # by far cheaper
    assert plan_of(in_two_halves(2.5), anchor=gentle, side=128).choice.kind == SMOOTH  # the mesh would not do


def test_frames_do_not_depend_on_each_other():
    frames = [waves(scale) for scale in (0.1, 0.5, 2.5)]
    own, settings = texels_of(frames[0]), Settings(tolerance=1e-2)
    anchor = prepare(frames[0], own, settings)
    kept = Kept(anchor)
    in_turn = [solve(scene, own, settings, kept).images[0] for scene in frames]
    alone = [solve(scene, own, settings, Kept(anchor)).images[0] for scene in reversed(frames)][::-1]
    for one, other in zip(in_turn, alone, strict=True):
        np.testing.assert_array_equal(one, other)


def test_no_jump_shows_where_an_animation_changes_character():
    """Waves that grow: from frame to frame the maps move no further than the converged ones do, and the tolerance."""
    tolerance, scales = 1e-2, np.linspace(0.1, 2.5, 6)
    frames = [waves(scale) for scale in scales]
    own, settings = texels_of(frames[0]), Settings(tolerance=tolerance)
    kept, finest = Kept(prepare(frames[0], own, settings)), Kept(Anchor(KNOWN))
    answers = [solve(scene, own, settings, kept) for scene in frames]
    true = [solve(scene, own, Settings("photon_splat", 1e-5), finest).images[0] for scene in frames]
    kinds = [answer.diagnostics.plan["choice"] for answer in answers]
    assert len(set(kinds)) == 3
    for k in range(len(frames) - 1):
        jump, moved = (np.sqrt(off(a[k + 1], a[k])) for a in ([s.images[0] for s in answers], true))
        assert jump <= moved + np.sqrt(tolerance)


def test_a_frame_like_the_anchor_is_planned_by_a_glance(monkeypatch):
    """Waves a tenth higher err a fifth more, as a look would find; that is told without one."""
    for scale, tolerance, name in ((0.3, 5e-2, FLAT), (0.4, 1e-2, MESH), (2.5, 1e-2, SMOOTH)):
        anchor, looked = (plan_of(waves(factor * scale), tolerance, side=128) for factor in (1.0, 1.1))
        assert anchor.choice.kind == name
        with monkeypatch.context() as patched:
            patched.setattr("dapple.kernels.plan.planner._looked", None)
            glanced = plan_of(waves(1.1 * scale), tolerance, anchor, side=128)
        assert (glanced.choice.kind, glanced.choice.without) == (anchor.choice.kind, anchor.choice.without)
        for measure in {FLAT: ("waves",), MESH: ("waves", "mesh", "power"), SMOOTH: ("power",)}[name]:
            assert glanced.measures[measure] == pytest.approx(looked.measures[measure], rel=0.05), (name, measure)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: replace(s, lights=(sun((0.3, 0.1, -1.0)),)),
        lambda s: replace(s, receivers=(quad("Floor", [[-2, -2, 0.1], [2, -2, 0.1], [2, 2, 0.1], [-2, 2, 0.1]]),)),
        lambda s: replace(s, receivers=(quad("Floor", [[-2, -2, -0.1], [2, -2, 0.1], [2, 2, 0.1], [-2, 2, -0.1]]),)),
        lambda s: replace(
            s, occluders=(Occluder("Sail", np.array([[0, 0, 3], [1, 0, 3], [0, 1, 3.0]]), np.array([[0, 1, 2]])),)
        ),
        lambda s: replace(s, sigma_a=np.ones(3)),
    ],
)
def test_what_changes_round_the_water_is_looked_at_anew(change, monkeypatch):
    anchor = plan_of(waves(0.4))
    monkeypatch.setattr("dapple.kernels.plan.planner._looked", lambda *_: pytest.fail("looked"))
    plan_of(waves(0.4), anchor=anchor)
    with pytest.raises(pytest.fail.Exception, match="looked"):
        plan_of(change(waves(0.4)), anchor=anchor)


@pytest.mark.parametrize("quads", [64, 128, 256])
def test_a_glance_sees_all_columns_of_a_grid(quads):
    """Waves that move on are the same waves, on meshes whose rows have as many triangles as are passed over, too."""
    x, y, triangles = grid(quads, 4.8)
    frames = [shaded_smooth(np.stack([x, y, 1.5 + sines(x + s, y, 0.1)[0]], 1), triangles) for s in (0.0, 0.3)]
    one, other = (plan_of(replace(waves(0.1), water=water)).glance for water in frames)
    assert other.over(one) is not None
