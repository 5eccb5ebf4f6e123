"""A bake that is killed ends with the files of one that was not; tests/bench/kill_test.py does so for longer."""

import os
import signal
import sys
import time

import pytest

from dapple.tests.blender.killing import bake_whole, differences, kill_often, save_waves, session, start

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc")


@pytest.mark.bpy_module
def test_a_bake_killed_twice_ends_with_the_same_files(empty_scene, tmp_path):
    blend = tmp_path / "waves.blend"
    save_waves(blend, frames=12)
    bake_whole(blend, tmp_path / "whole", 2)
    maps = {path.read_bytes() for path in (tmp_path / "whole").rglob("*.exr")}
    assert len(maps) == 12, "the water moves"
    said = list(kill_often(blend, tmp_path / "killed", 2, 12, 2, seed=5))
    assert differences(tmp_path / "whole", tmp_path / "killed") == [], said
    assert "12 frames were there" not in said[-1], said


@pytest.mark.bpy_module
def test_ctrl_c_stops_within_a_second_with_a_sentence(empty_scene, tmp_path):
    """As from a terminal: the signal goes to the whole group, and only the bake itself answers it."""
    blend = tmp_path / "waves.blend"
    save_waves(blend, frames=100)
    process = start(blend, tmp_path / "out", 2)
    lines = iter(process.stdout.readline, "")
    assert any(line.startswith("[2/") for line in lines)
    begun = time.monotonic()
    for member in session(process.pid):
        os.kill(member, signal.SIGINT)
    said = process.communicate()[0]
    assert time.monotonic() - begun < 1
    assert process.returncode == 1
    assert "dapple: stopped; the finished frames are kept." in said
    assert "Traceback" not in said
    assert session(process.pid) == []
