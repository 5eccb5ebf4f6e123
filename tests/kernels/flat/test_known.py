"""Still water from frame to frame: one light as long as the plane holds, and the same light whatever came before."""

from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, grid, pool, quad, shaded_smooth, sun

from dapple.kernels.anchor import Anchor, Kept
from dapple.kernels.flat import known
from dapple.kernels.flat.known import KnownStill
from dapple.kernels.flat.level import Level
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import prepare, solve
from dapple.kernels.scene import Occluder, Settings

FLAT = Settings("flat")
WALL = quad("Wall", [[1.2, -2, -0.1], [1.2, 2, -0.1], [1.2, 2, 1.7], [1.2, -2, 1.7]])


def frame(phase, scale=0.1, level=1.5, **words):
    """The pool within a wall, its waves shifted along by `phase` [m]."""
    x, y, triangles = grid(32, 4.0)
    height = five_sines(x + phase, y, scale)[0]
    wall = Occluder("Wall", WALL.positions, WALL.triangles)
    scene = pool(quads=2, occluders=[wall])
    return replace(scene, water=shaded_smooth(np.stack([x, y, level + height], 1), triangles), **words)


def texels_of(scene):
    return tuple(rasterise(receiver, 48) for receiver in scene.receivers)


def test_waves_about_one_plane_have_one_light_made_once(monkeypatch):
    frames = [frame(phase) for phase in (0.0, 0.1, 0.2)]
    own = texels_of(frames[0])
    kept = Kept(prepare(frames[0], own, FLAT))
    first = solve(frames[0], own, FLAT, kept)
    monkeypatch.setattr(known.StillLight, "of", lambda *_: pytest.fail("made again"))
    others = [solve(scene, own, FLAT, kept) for scene in frames[1:]]
    for answer, scene in zip(others, frames[1:], strict=True):
        np.testing.assert_array_equal(answer.images[0], first.images[0])
        assert answer.diagnostics.estimated_error != first.diagnostics.estimated_error
        monkeypatch.undo()
        alone = solve(scene, own, FLAT)
        off = ((alone.images[0] - answer.images[0]) ** 2).mean() / (alone.images[0] ** 2).mean()
        assert off < 0.1 * alone.diagnostics.estimated_error
        assert answer.diagnostics.estimated_error == pytest.approx(alone.diagnostics.estimated_error, rel=0.1)


CHANGES = {
    "level": {"level": 1.2},
    "sun": {"lights": (sun((0.5, 0.0, -1.0)),)},
    "murk": {"sigma_a": np.array([0.4, 0.1, 0.0])},
    "no wall": {"occluders": ()},
    "eta": {"eta": 1.5},
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_what_changes_the_light_makes_it_anew_and_history_tells_nothing(change):
    first, then = frame(0.0), frame(0.1, **change)
    own = texels_of(first)
    anchor = prepare(first, own, FLAT)
    kept = Kept(anchor)
    in_turn = [solve(scene, own, FLAT, kept) for scene in (first, then, first)]
    alone = [solve(scene, own, FLAT, Kept(anchor)) for scene in (first, then, first)]
    for one, other in zip(in_turn, alone, strict=True):
        np.testing.assert_array_equal(one.images[0], other.images[0])
        for name in ("estimated_error", "flux_received", "flux_lost", "texels", "left_out", "method", "reason"):
            assert str(getattr(one.diagnostics, name)) == str(getattr(other.diagnostics, name))
    assert not np.array_equal(in_turn[0].images[0], in_turn[1].images[0])


def test_no_frame_writes_into_what_another_shares():
    scene = frame(0.0)
    own = texels_of(scene)
    kept = Kept(prepare(scene, own, FLAT))
    one = solve(scene, own, FLAT, kept)
    one.diagnostics.flux_lost.clear()
    one.diagnostics.left_out.append("mine")
    with pytest.raises(ValueError, match="read-only"):
        one.images[0][:] = 0
    other = solve(scene, own, FLAT, kept)
    assert other.diagnostics.flux_lost and "mine" not in other.diagnostics.left_out


def test_a_plane_holds_while_the_waves_are_higher_than_it_is_off():
    level, texel = Level.of(frame(0.0).water), 0.05
    assert level.holds(frame(0.3).water, texel)
    assert not level.holds(frame(0.0, level=1.6).water, texel)
    assert level.holds(frame(0.0, scale=1.0, level=1.51).water, texel)
    tilted = frame(0.0).water
    positions = tilted.positions + 0.1 * tilted.positions[:, :1] * [0, 0, 1]
    assert not level.holds(replace(tilted, positions=positions), texel)
    wider = replace(tilted, positions=tilted.positions * [1.01, 1.0, 1.0])
    assert not level.holds(wider, texel) and level.holds(wider, 0.4)


def test_water_that_is_closed_has_no_level_to_keep():
    closed = frame(0.0).water
    assert Level.of(replace(closed, twins=np.zeros_like(closed.twins))) is None
    assert Anchor().level is None and KnownStill().solve(frame(0.0), texels_of(frame(0.0)), FLAT).images[0].any()
