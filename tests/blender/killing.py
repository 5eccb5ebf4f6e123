"""Bakes that are killed: processes of their own, ended without warning in the midst of whatever they are at."""

import json
import math
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def save_waves(path, frames, quads=48, resolution=64):
    """Save a file with `frames` frames of waves over a floor, that bakes with the real methods."""
    import bpy

    from dapple.tests.blender.small_pool import add_grid, build_pool

    scene = bpy.context.scene
    build_pool(scene, "//out")
    old = scene.dapple.water
    water = add_grid("Waves", 1.0, n=quads)
    wave = water.modifiers.new("Wave", "WAVE")
    wave.height, wave.width, wave.narrowness, wave.time_offset = 0.04, 0.4, 4.0, -60.0
    bpy.data.objects.remove(old)
    scene.dapple.water, scene.dapple.resolution = water, resolution
    bpy.data.objects["Sun"].rotation_euler.x = math.radians(20)
    scene.frame_start, scene.frame_end = 1, frames
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def start(blend, out, workers):
    """A bake of the file as a process with a session of its own, that hears Ctrl-C even where this one does not, as
    jobs in the background do not."""
    command = [sys.executable, "-P", str(ROOT / "dapple"), "bake", str(blend), "--out", str(out)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    pipes["preexec_fn"] = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    return subprocess.Popen([*command, "--workers", str(workers)], start_new_session=True, **pipes)


def bake_whole(blend, out, workers):
    """Bake to the end; returns what was printed. AssertionError where it fails."""
    process = start(blend, out, workers)
    said, _ = process.communicate()
    assert process.returncode == 0, said
    return said


def kill_at(blend, out, workers, done, delay, group):
    """Bake until so many frames are done, and `delay` s longer; then kill the process, or its whole group at once.

    Returns how many frames were done at last. AssertionError where a process of the bake is left after 2 s.
    """
    process, found = start(blend, out, workers), 0
    for line in process.stdout if done else ():
        if match := re.match(r"\[(\d+)/", line):
            found = int(match[1])
        if found >= done:
            break
    time.sleep(delay)
    (os.killpg if group else os.kill)(process.pid, signal.SIGKILL)
    process.communicate()
    until = time.monotonic() + 2
    while left := session(process.pid):
        assert time.monotonic() < until, f"processes {left} outlived their bake"
        time.sleep(0.02)
    return found


def session(leader):
    """Numbers of the processes of a session that run."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, *rest = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if state != "Z" and int(rest[2]) == leader:
            found.append(int(stat.parent.name))
    return found


def kill_often(blend, out, workers, frames, kills, seed):
    """Kill a bake so many times at random moments and then let it end; yields a sentence on each."""
    draw = random.Random(seed)
    for k, done in enumerate(sorted(draw.randrange(3 * frames // 4) for _ in range(kills))):
        delay, group = draw.uniform(0, 0.15 if done else 2.0), k % 2 == 0
        found = kill_at(blend, out, workers, done, delay, group)
        yield f"killed {'all processes' if group else 'the main process'} {delay:.2f} s after {found} frames were done"
    said = bake_whole(blend, out, workers)
    yield f"then to the end: {said.count('left as it is')} frames were there, {said.count('received')} were baked"


def differences(one, other):
    """How two folders of bakes differ: maps by their bytes, bake.json but for the seconds."""
    names = [sorted(p.relative_to(f).as_posix() for p in f.rglob("*") if p.is_file()) for f in (one, other)]
    if names[0] != names[1]:
        return [f"files: {set(names[0]) ^ set(names[1])}"]
    unequal = [
        name for name in names[0] if name != "bake.json" and (one / name).read_bytes() != (other / name).read_bytes()
    ]
    records = [timeless(json.loads((folder / "bake.json").read_text())) for folder in (one, other)]
    return unequal + [f"bake.json: {key}" for key in unlike(*records)]


def unlike(one, other):
    """The places, as keys between slashes, at which two records differ."""
    if isinstance(one, dict) and isinstance(other, dict):
        keys = sorted({*one, *other})
        return [f"{key}/{inner}" for key in keys for inner in unlike(one.get(key), other.get(key))]
    return [] if one == other else [""]


def timeless(record):
    """A record without its seconds."""
    if isinstance(record, dict):
        return {key: timeless(value) for key, value in record.items() if key != "seconds"}
    return [timeless(value) for value in record] if isinstance(record, list) else record
