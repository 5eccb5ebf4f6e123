"""A bake that is killed ends with the files of one that was not; tests/bench/kill_test.py does so for longer."""

import json
import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path

import bpy
import pytest

from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.bake.progress import Progress, Waiting
from dapple.operators.maps.exr_file import is_whole
from dapple.tests.blender.killing import bake_whole, differences, kill_often, save_waves, session, start
from dapple.tests.blender.small_pool import files_in

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks at /proc")
tells_how_it_ended = pytest.mark.skipif(
    bpy.app.version < (5, 0), reason="as a module, Blender 4 crashes when Python ends, with all done"
)


@tells_how_it_ended
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


def test_closing_the_iterator_stops_within_a_second_and_keeps_whole_frames(empty_scene, tmp_path):
    """What Esc does, in the midst of a frame of each worker."""
    save_waves(tmp_path / "waves.blend", frames=100)
    request = replace(request_from_scene(bpy.context.scene, out=tmp_path / "out"), workers=2)
    steps = bake(bpy.context, request, wait=0.01)
    done = next(step for step in steps if isinstance(step, Progress))
    next(step for step in steps if isinstance(step, Waiting) and step.message.count("light") == 2)
    workers = children()
    assert len(workers) == 2
    begun = time.process_time()
    steps.close()
    assert time.process_time() - begun < 0.5
    assert not workers & children()
    entries = json.loads((tmp_path / "out" / "bake.json").read_text())["frames"]
    assert str(done.frame) in entries
    maps = {tmp_path / "out" / file for entry in entries.values() for file in entry["files"].values()}
    assert {tmp_path / "out" / name for name in files_in(tmp_path / "out")} == maps | {tmp_path / "out" / "bake.json"}
    assert all(map(is_whole, maps))


def children():
    """Numbers of the processes that this one has started and that run."""
    return {int(n) for n in Path("/proc/self/task", str(os.getpid()), "children").read_text().split()}


@tells_how_it_ended
@pytest.mark.bpy_module
def test_ctrl_c_stops_at_once_with_a_sentence(empty_scene, tmp_path):
    """As from a terminal: the signal goes to the whole group, and only the bake itself answers it."""
    blend = tmp_path / "waves.blend"
    save_waves(blend, frames=100)
    process = start(blend, tmp_path / "out", 2)
    lines = iter(process.stdout.readline, "")
    assert any(line.startswith("[2/") for line in lines)
    for member in session(process.pid):
        os.kill(member, signal.SIGINT)
    said = process.communicate()[0]
    # How long that takes is up to what else the machine does; of 100 frames no more come than were under way.
    assert said.count("\n[") <= 4
    assert process.returncode == 1
    assert "dapple: stopped; the finished frames are kept." in said
    assert "Traceback" not in said
    assert session(process.pid) == []
