"""The reference and the chart of small pools, where all is quick."""

from dataclasses import replace

import numpy as np
import pytest
import waves
from casters import ball, no_water

from dapple.kernels.chart.chart import Row, build, join, marked
from dapple.kernels.chart.ladder import rungs
from dapple.kernels.chart.reference import reference
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, solve
from dapple.kernels.scene import Scene, Settings
from dapple.kernels.trace.cast import Cast

RESOLUTION = 16


def run(steps):
    """What the steps return, and the sentences on the way."""
    said = []
    while True:
        try:
            said.append(next(steps))
        except StopIteration as end:
            return end.value, said


@pytest.fixture(scope="module")
def pool():
    """A Scene of few triangles, its Texels."""
    scene = waves.pool(quads=32)
    return scene, (rasterise(scene.receivers[0], RESOLUTION),)


def test_the_reference_is_the_light_that_points_find(pool):
    scene, texels = pool
    truth, _ = run(reference(scene, texels, Settings(surface="mesh")))
    points = solve(scene, texels, Settings("photon_splat", 1e-4, points=True, surface="mesh"))
    light = points.images[0].reshape(-1, 3)[texels[0].texel]
    assert truth.suns == 0
    assert 0 < truth.error < 1e-5
    assert truth.maps.error_by_mean(light) < 2e-4


def test_a_wide_sun_is_many_suns_that_know_their_error(pool):
    scene, _ = pool
    texels = (rasterise(scene.receivers[0], 48),)
    wide = replace(scene, lights=tuple(replace(light, angle=np.radians(4)) for light in scene.lights))
    truth, said = run(reference(wide, texels, Settings(surface="mesh")))
    assert truth.suns >= 4
    assert any(f"{truth.suns} suns" in sentence for sentence in said)
    sharp, _ = run(reference(scene, texels, Settings(surface="mesh")))
    blurred = solve(wide, texels, Settings("photon_splat", 1e-4, surface="mesh"))
    light = blurred.images[0].reshape(-1, 3)[texels[0].texel]
    assert 0 < truth.error < 1e-3
    assert truth.maps.error_by_mean(light) < 0.1 * truth.maps.error_by_mean(sharp.maps.light)


def test_the_reference_over_glass_knows_what_its_halves_have_in_common():
    """A focus that all beams blur alike is no difference between the halves."""
    light = replace(waves.sun((0, 0, -1)), angle=np.radians(0.5))
    glass = (ball(0.4, fine=12),)
    scene = Scene(no_water(), (waves.floor(),), (), (light,), casters=glass)
    texels = (rasterise(scene.receivers[0], 48),)
    truth, _ = run(reference(scene, texels, Settings()))
    fine = solve(replace(scene, lights=(replace(light, angle=0.0),)), texels, Settings("photon_splat", 3e-4))
    assert truth.suns >= 4
    assert truth.error >= fine.diagnostics.estimated_error > 0


def test_every_method_is_a_rung_and_auto_comes_last(pool):
    scene, _ = pool
    found = rungs(scene, Settings())
    assert {rung.method for rung in found} == {*METHODS, "auto"}
    assert found[-1].method == "auto"
    assert all(settings.resolution == 64 for rung in found for _, settings in rung.settings(Settings(resolution=64)))


def test_the_mesh_is_a_rung_only_where_the_smooth_water_is_another(pool):
    scene, _ = pool
    names = {rung.name for rung in rungs(scene, Settings())}
    assert names - {rung.name for rung in rungs(scene, Settings(surface="mesh"))} == {"photon_splat, mesh as it is"}


def test_without_water_there_are_the_rungs_over_casters(pool):
    scene, _ = pool
    assert {r.method for r in rungs(replace(scene, water=no_water()), Settings())} == {
        "caustic_map",
        "photon_splat",
        "auto",
    }


def test_a_chart_of_some_rungs_and_a_peer(pool):
    scene, texels = pool
    count = len(texels[0].texel)

    def peer(given, settings, own):
        assert (given.water.name, own) == (scene.water.name, texels)
        yield "peer: waiting", None
        known = {"rung": "peer", "label": "dark", "method": "peer", "asked": None, "seconds": 1e-9, "runs": 1}
        yield "peer: dark", {**known, "light": np.zeros((count, 3)), "seen": np.arange(count) < count // 2}

    chart, _ = run(build(scene, texels, Settings(), ("flat", "photon_splat", "auto"), lambda *_: 0.25))
    _, said = run(join(chart, scene, texels, Settings(), (peer,)))
    by = {(row.rung, row.label): row for row in chart.rows}
    assert {row.rung for row in chart.rows} == {"flat", "photon_splat", "photon_splat, mesh as it is", "auto", "peer"}
    fine, rough = (
        by["photon_splat", "0.0003"].error,
        by["photon_splat", "0.1"].error,
    )  # on so few texels one surface does
    assert fine < 1.001 * rough < by["flat", "still water"].error
    assert all(row.flip == (None if row.peer else 0.25) for row in chart.rows)
    assert all(row.seconds > 0 and row.energy < 0.02 for row in chart.rows)
    assert by["peer", "dark"].error == pytest.approx(1.0)
    assert by["peer", "dark"].energy == -1.0
    assert by["peer", "dark"].seen == pytest.approx(0.5, abs=0.01)
    assert by["peer", "dark"].on_front
    assert all((row.over_front is None) == (row.rung != "auto") for row in chart.rows)
    assert said == ["peer: waiting", f"peer: dark, error {by['peer', 'dark'].error:.2g}"]


def test_no_light_over_glass_is_kept_from_what_was_timed_before(monkeypatch):
    glass, followed = (ball(0.4, fine=8),), []
    scene = Scene(no_water(), (waves.floor(),), (), (waves.sun((0, 0, -1)),), casters=glass)
    texels = (rasterise(scene.receivers[0], RESOLUTION),)
    follow = Cast.follow
    monkeypatch.setattr(Cast, "follow", lambda self: followed.append(self) or follow(self))
    chart, _ = run(build(scene, texels, Settings(), ("photon_splat",)))
    assert len(chart.rows) > 1
    assert len(followed) >= sum(1 if row.runs == 1 else 1 + row.runs for row in chart.rows)


def row(rung, seconds, error, peer=False):
    return Row(rung, "", rung, None, seconds, 1, error, error, error, 0.0, peer=peer)


def test_errors_below_that_of_the_reference_are_alike():
    rows = marked([row("quick", 1.0, 1e-6), row("slow", 2.0, 1e-9), row("auto", 3.0, 1e-8)], 1e-5)
    assert [r.on_front for r in rows] == [True, False, False]
    assert [r.below_floor for r in rows] == [True, True, True]
    assert rows[2].over_front == pytest.approx(3.0)


def test_auto_is_measured_against_our_own_rungs():
    rows = marked([row("ours", 2.0, 0.1), row("peer", 1.0, 0.1, peer=True), row("auto", 3.0, 0.1)], 0.0)
    assert [r.on_front for r in rows] == [False, True, False]
    assert rows[2].over_front == pytest.approx(1.5)
