"""Other renderers that join charts, where the light is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
import waves
from bench import peer_cycles, peers

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Settings

RESOLUTION = 8


def pond(direction, shape=waves.flat):
    """Water over a floor that lies in its light as a whole, under a sun; the floor's Texels."""
    scene = waves.pool(shape, quads=16, direction=direction, side=9.6)
    return scene, (rasterise(scene.receivers[0], RESOLUTION),)


@pytest.fixture
def one_sample(empty_scene, monkeypatch):
    monkeypatch.setattr(peer_cycles, "SAMPLES", (1,))


@pytest.mark.parametrize("degrees", [5, 30, 60])
def test_cycles_finds_all_the_light_of_still_water(one_sample, degrees):
    angle = np.radians(degrees)
    scene, texels = pond((np.sin(angle), 0, -np.cos(angle)))
    (run,) = peer_cycles.runs(scene, texels)
    true = np.cos(angle) * waves.transmitted(np.cos(angle))
    assert run["light"] == pytest.approx(true, rel=1e-3)
    assert run["seconds"] > 0


def test_cycles_finds_no_light_under_a_sun_overhead(one_sample):
    (run,) = peer_cycles.runs(*pond((0, 0, -1)))
    assert not run["light"].any()


def test_light_that_meets_no_water_is_taken_off(one_sample):
    scene, texels = pond((0.3, 0, -1))
    shrunk = replace(scene.water, positions=scene.water.positions * (1 / 8, 1 / 8, 1))
    (run,) = peer_cycles.runs(replace(scene, water=shrunk), texels)
    bright = run["light"][:, 0] > 0.05
    assert 0.02 < bright.mean() < 0.3  # 1.2 m of 4 m, each way
    assert np.abs(run["light"][~bright]).max() < 0.05


def test_lamps_are_refused_in_a_sentence():
    from types import SimpleNamespace

    with pytest.raises(ValueError, match="suns only"):
        next(peer_cycles.runs(SimpleNamespace(lights=(object(),)), ()))


@pytest.mark.bpy_module
def test_a_peer_that_fails_is_told_of(tmp_path, monkeypatch):
    script = tmp_path / "broken.py"
    script.write_text("raise SystemExit('nothing to trace')\n")
    said = list(peers._peer("It", str(script), *with_settings(pond((0.3, 0, -1))), "; a hint"))
    assert said == [("It: working", None), ("It cannot take part: nothing to trace; a hint", None)]


@pytest.mark.bpy_module
def test_cycles_joins_from_a_process_of_its_own(tmp_path):
    said = list(peers.cycles(*with_settings(pond((0.3, 0, -1)))))
    assert said[0] == ("Cycles: working", None)
    assert [run["label"] for _, run in said[1:]][:2] == ["1 sample", "4 samples"]


def with_settings(given):
    scene, texels = given
    return scene, Settings(surface="mesh"), texels
