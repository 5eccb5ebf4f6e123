"""A bake under way: workers that answer in any order, or die, people that work on, and folders that go."""

import os
from dataclasses import replace

import bpy
import numpy as np
import pytest

from dapple.operators.bake import bake as bake_module
from dapple.operators.bake.bake import bake, request_from_scene
from dapple.operators.bake.messages import Died
from dapple.operators.bake.progress import Progress, Waiting
from dapple.operators.bake.turns import clear_up, partial_path
from dapple.operators.errors import DappleError
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import InlinePool, content, files_in, record, run


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


class Backwards(InlinePool):
    """Two workers, of which the second is done first."""

    @property
    def has_room(self):
        return len(self.busy) < 2

    def answers(self, seconds=None):
        if self.has_room and not seconds:
            return []
        return sorted(super().answers(seconds), key=lambda one: -one[0].number)


def test_the_order_of_the_answers_changes_nothing(pool, out, monkeypatch, tmp_path):
    run(pool, frames=(1, 2, 3, 4))
    monkeypatch.setattr(bake_module, "Pool", Backwards)
    progress = run(pool, frames=(1, 2, 3, 4), out=tmp_path / "other")
    assert [p.frame for p in progress] == [2, 1, 4, 3]
    assert [p.done for p in progress] == [1, 2, 3, 4]
    one, other = content(out), content(tmp_path / "other")
    assert one.pop("bake.json") != b"" and other.pop("bake.json") != b""
    assert one == other
    assert list(record(tmp_path / "other")["frames"]) == ["1", "2", "3", "4"]


class Mortal(Backwards):
    """Its workers die of frame 2, as often as `deaths` says; alone: the frames that were given while no other was."""

    deaths, alone = 1, ()

    def give(self, job):
        if not self.busy:
            self.alone = (*self.alone, job.number)
        if job.number == 2 and self.deaths:
            self.deaths -= 1
            self.busy.append(job)
            self._said.append((job, Died(-9)))
        else:
            super().give(job)


def test_a_frame_that_a_worker_died_of_is_tried_again_alone(pool, out, monkeypatch):
    one = Mortal(2)
    monkeypatch.setattr(bake_module, "Pool", lambda _: one)
    progress = run(pool, frames=(1, 2, 3, 4))
    assert sorted(p.frame for p in progress) == [1, 2, 3, 4]
    assert 2 in one.alone
    np.testing.assert_allclose(read_exr(out / "Floor/caustics_0002.exr"), 1.1, rtol=2e-3)


def test_a_frame_that_workers_died_of_twice_ends_the_bake_and_keeps_the_others(pool, out, monkeypatch):
    monkeypatch.setattr(Mortal, "deaths", 2)
    monkeypatch.setattr(bake_module, "Pool", Mortal)
    with pytest.raises(DappleError, match=r"Frame 2: the process that solved it ended .*\(code -9\).*fewer workers"):
        run(pool, frames=(1, 2, 3, 4))
    assert files_in(out) == ["Floor/caustics_0001.exr", "bake.json"]


def test_people_are_told_what_goes_on(pool, monkeypatch):
    monkeypatch.setattr(bake_module, "Pool", Backwards)
    steps = list(bake(bpy.context, request_from_scene(pool), wait=0.001))
    waits = [step for step in steps if isinstance(step, Waiting)]
    assert [step.frame for step in steps if isinstance(step, Progress)] == [2, 1, 3]
    assert all(step.total == 3 for step in waits)
    assert waits[0].left is None
    assert waits[-1].left == 0.0


def test_people_stay_at_their_frame_while_frames_are_read(pool):
    pool.frame_set(7, subframe=0.25)
    steps = bake(bpy.context, request_from_scene(pool), wait=0.001)
    for step in steps:
        assert (pool.frame_current, pool.frame_subframe) == (7, 0.25)
        if isinstance(step, Progress) and step.frame == 2:
            pool.frame_set(9)  # they go on
            break
    assert [pool.frame_current for _ in steps][-1] == 9


def test_an_undo_between_frames_does_no_harm(pool, out):
    """It gives all data new addresses; here by reading the file anew, which does so too."""
    path = out.parent / "pool.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    steps = bake(bpy.context, request_from_scene(bpy.context.scene), wait=0.001)
    next(step for step in steps if isinstance(step, Progress))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert [step.frame for step in steps if isinstance(step, Progress)] == [2, 3]


def test_a_scene_that_goes_away_is_said(pool):
    steps = bake(bpy.context, request_from_scene(pool))
    next(steps)
    pool.name = "Another"
    with pytest.raises(DappleError, match=r"Frame 2: Scene 'Scene' or its view layer .* is gone"):
        list(steps)


def test_a_folder_that_goes_away_is_said_and_not_made_anew(pool, out):
    steps = bake(bpy.context, request_from_scene(pool))
    next(steps)
    out.rename(out.with_name("unmounted"))
    with pytest.raises(DappleError, match=r"The output folder .* is gone; connect its drive"):
        list(steps)
    assert not out.exists()
    assert files_in(out.with_name("unmounted")) == ["Floor/caustics_0001.exr", "bake.json"]


def test_two_bakes_of_one_folder_keep_each_others_frames(pool, out):
    one = bake(bpy.context, replace(request_from_scene(pool), frames=(1, 3)))
    other = bake(bpy.context, replace(request_from_scene(pool), frames=(2, 4)))
    for _ in range(2):
        next(one)
        next(other)
    assert [*one, *other] == []
    assert list(record(out)["frames"]) == ["1", "2", "3", "4"]
    assert len(files_in(out)) == 5


def test_what_killed_bakes_left_is_cleared_up_and_what_others_write_is_not(out, tmp_path):
    (out / "Floor").mkdir(parents=True)
    mine = partial_path(out / "Floor/caustics_0001.exr")
    left = mine.with_name(mine.name.replace(f"-{os.getpid()}.", "-4194303."))  # above the highest number by default
    far = mine.with_name(
        mine.name.replace(".caustics_0001.", ".caustics_0001.ffffffff-").replace("ffffffff-", "0" * 8, 1)
    )
    for path in (mine, left, far):
        path.write_bytes(b"half")
    clear_up(out)
    assert mine.exists() and not left.exists() and far.exists()


def test_anchor_is_the_first_frame_of_the_range_whatever_is_asked_for(pool, solved, monkeypatch):
    asked = []
    real = InlinePool.give
    monkeypatch.setattr(InlinePool, "give", lambda self, job: (asked.append((job.number, job.anchor)), real(self, job)))
    run(pool, frames=(3,))
    assert [number for number, _ in asked] == [1, 3]
    assert asked[0][1] is None
    run(pool)
    assert solved == [1.2, 1.0, 1.1], "frame 3 is as it would be in the animation"


def test_a_range_that_starts_with_nothing_to_bake_bakes_each_frame_alone(pool, out):
    water = pool.dapple.water
    water.hide_viewport = True
    water.keyframe_insert("hide_viewport", frame=1)
    water.hide_viewport = False
    water.keyframe_insert("hide_viewport", frame=2)
    run(pool, frames=(2, 3))
    assert list(record(out)["frames"]) == ["2", "3"]
