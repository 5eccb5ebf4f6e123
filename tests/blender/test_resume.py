"""What a bake leaves as it is, since it is there, and what it makes anew."""

import errno
import json
from pathlib import Path

import bpy
import pytest

from dapple.operators.errors import DappleError
from dapple.tests.blender.small_pool import content, files_in, record, run


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def test_what_is_on_disk_is_left_as_it_is_and_said(pool, out, solved):
    run(pool, frames=(1, 2))
    before = content(out)
    progress = run(pool)
    assert solved == [1.0, 1.1, 1.2]
    assert [p.done for p in progress] == [1, 2, 3]
    assert progress[1].message == "Frame 2 is on disk, made from the same: left as it is."
    assert progress[1].maps == (out / "Floor/caustics_0002.exr",)
    after = content(out)
    assert all(after[name] == before[name] for name in before if name.endswith("exr"))
    assert record(out)["frames"]["1"] == json.loads(before["bake.json"])["frames"]["1"]


def test_a_changed_frame_is_redone_and_no_other(pool, out, solved):
    run(pool)
    floor = bpy.data.objects["Floor"]
    for frame, z in ((2, 0.0), (3, 1e-4), (4, 0.0)):  # a tenth of a millimetre, on one frame
        floor.location.z = z
        floor.keyframe_insert("location", frame=frame)
    solved.clear()
    run(pool)
    assert solved == [1.2]


CHANGES = {
    "water": lambda scene: setattr(scene.dapple.water.data.vertices[3].co, "z", 0.01),
    "uvs": lambda scene: setattr(bpy.data.objects["Floor"].data.uv_layers[0].uv[0], "vector", (0.01, 0.0)),
    "lamp": lambda scene: setattr(bpy.data.lights["Sun"], "energy", 1.5),
    "occluder": lambda scene: bpy.ops.mesh.primitive_cube_add(location=(0, 0, 3)),
    "setting": lambda scene: setattr(scene.dapple, "padding", 2),
    "depth": lambda scene: setattr(scene.dapple, "depth", "FULL"),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_whatever_a_map_follows_from_redoes_it(pool, solved, change):
    run(pool, frames=(1,))
    change(pool)
    run(pool, frames=(1,))
    assert len(solved) == 2


def test_another_version_of_dapple_redoes_all(pool, solved, monkeypatch):
    run(pool, frames=(1,))
    monkeypatch.setattr("dapple.operators.bake.run.code", lambda: "another")
    run(pool, frames=(1,))
    assert len(solved) == 2


@pytest.mark.parametrize("harm", ["cut", "another", "gone"])
def test_a_map_that_is_not_the_one_that_was_written_is_redone(pool, out, solved, harm):
    run(pool, frames=(1, 2))
    path, good = out / "Floor/caustics_0002.exr", (out / "Floor/caustics_0002.exr").read_bytes()
    if harm == "gone":
        path.unlink()
    else:
        path.write_bytes(good[:-1] if harm == "cut" else (out / "Floor/caustics_0001.exr").read_bytes())
    run(pool, frames=(1, 2))
    assert solved == [1.0, 1.1, 1.1]
    assert path.read_bytes() == good


def test_a_frame_as_an_earlier_one_gets_its_maps(pool, out, solved):
    water = pool.dapple.water
    water.driver_remove("location")
    for frame, z in ((1, 1.0), (2, 1.5), (3, 1.0)):
        water.location.z = z
        water.keyframe_insert("location", frame=frame)
    progress = run(pool)
    assert solved == [1.0, 1.5]
    assert progress[2].message == "Frame 3 is as frame 1: nothing differs."
    maps = content(out)
    assert maps["Floor/caustics_0003.exr"] == maps["Floor/caustics_0001.exr"] != maps["Floor/caustics_0002.exr"]
    frames = record(out)["frames"]
    assert frames["3"]["same_as"] == 1
    assert frames["3"]["inputs"] == frames["1"]["inputs"]
    (out / "Floor/caustics_0003.exr").unlink()
    run(pool)
    assert solved == [1.0, 1.5], "it is copied from the one that is there"
    assert content(out)["Floor/caustics_0003.exr"] == maps["Floor/caustics_0003.exr"]


def test_light_that_is_kept_from_frame_to_frame_is_solved_from_the_start(pool, solved):
    pool.dapple.reuse = 0.5
    run(pool, frames=(1, 2))
    run(pool)
    assert solved == [1.0, 1.1, 1.0, 1.1, 1.2]


def test_a_full_disk_loses_nothing_and_the_bake_goes_on_when_there_is_space(pool, out, solved, monkeypatch):
    real = Path.write_bytes

    def write(path, content):
        if "0002" in path.name:
            real(path, content[: len(content) // 2])
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, content)

    monkeypatch.setattr(Path, "write_bytes", write)
    with pytest.raises(DappleError, match=r"caustics_0002\.exr: no space left on the disk"):
        run(pool)
    assert files_in(out) == ["Floor/caustics_0001.exr", "bake.json"]
    assert list(record(out)["frames"]) == ["1"]
    monkeypatch.setattr(Path, "write_bytes", real)
    solved.clear()
    run(pool)
    assert solved == [1.1, 1.2]


def test_a_bake_that_was_killed_between_maps_and_record_makes_them_again(pool, out, solved):
    """The maps of frame 2 are of one scene, its entry of another, and the scene is as it was for the entry."""
    run(pool, frames=(1, 2))
    before = (out / "bake.json").read_bytes()
    good = content(out)
    bpy.data.lights["Sun"].energy = 2.0
    water = pool.dapple.water
    water.driver_remove("location")
    water.location.z = 3.0
    run(pool, frames=(2,))
    (out / "bake.json").write_bytes(before)
    assert content(out)["Floor/caustics_0002.exr"] != good["Floor/caustics_0002.exr"]
    bpy.data.lights["Sun"].energy = 1.0
    water.driver_add("location", 2).driver.expression = "1 + (frame - 1) / 10"
    run(pool, frames=(1, 2))
    assert content(out)["Floor/caustics_0002.exr"] == good["Floor/caustics_0002.exr"]
