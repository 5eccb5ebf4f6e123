"""What is read back is what was written, and a disk that fails leaves what there was."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from dapple.operators.errors import DappleError
from dapple.operators.maps.exr_file import is_whole
from dapple.operators.maps.write import folder_name, map_path, write_exr, write_json
from dapple.tests.blender.exr_reader import read_exr

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("size", [(16, 24), (1, 1), (17, 3), (40, 5)])
def test_full_floats_and_orientation_are_kept(size, tmp_path):
    image = np.random.default_rng(7).lognormal(0.0, 3.0, (*size, 3)).astype(np.float32)
    image[0, 0], image[-1, 0] = (0.0, 1e-6, 30.0), (0.5, 7.0, 1e5)
    write_exr(tmp_path / "new" / "map.exr", image.astype(float), full=True)
    back = read_exr(tmp_path / "new" / "map.exr")
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, image)


def test_half_floats_keep_eleven_bits_and_the_energy(tmp_path):
    image = np.random.default_rng(7).lognormal(0.0, 2.0, (64, 48, 3))
    write_exr(tmp_path / "map.exr", image)
    back = read_exr(tmp_path / "map.exr")
    assert back.dtype == np.float16
    normal = image >= 2.0**-14
    assert normal.mean() > 0.99
    assert (np.abs(back.astype(float) - image) / image)[normal].max() <= 2.0**-11
    assert back.astype(float).sum() == pytest.approx(image.sum(), rel=1e-4)


@pytest.mark.parametrize("value", [70000.0, 1e-6])
def test_light_that_half_floats_cannot_hold_is_kept_in_full(value, tmp_path):
    image = np.full((20, 20, 3), value, np.float32)
    write_exr(tmp_path / "map.exr", image)
    np.testing.assert_array_equal(read_exr(tmp_path / "map.exr"), image)


def test_blender_reads_what_openexr_reads(tmp_path):
    write_exr(tmp_path / "map.exr", np.random.default_rng(7).lognormal(0.0, 2.0, (33, 20, 3)))
    image = bpy.data.images.load(str(tmp_path / "map.exr"))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(33 * 20 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    np.testing.assert_array_equal(pixels.reshape(33, 20, 4)[..., :3], read_exr(tmp_path / "map.exr"))
    bpy.data.images.remove(image)


def test_the_same_map_gives_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        write_exr(tmp_path / f"{name}.exr", np.ones((40, 40, 3)))
    assert (tmp_path / "one.exr").read_bytes() == (tmp_path / "two.exr").read_bytes()


def test_no_image_stays_in_the_file(tmp_path):
    before = len(bpy.data.images)
    write_exr(tmp_path / "map.exr", np.zeros((4, 4, 3)))
    assert len(bpy.data.images) == before
    assert [p.name for p in tmp_path.iterdir()] == ["map.exr"]


@pytest.mark.parametrize("image", [np.zeros((4, 4)), np.zeros((4, 4, 4)), np.full((4, 4, 3), np.nan)])
def test_what_is_no_map_is_refused(tmp_path, image):
    with pytest.raises(ValueError, match="image must"):
        write_exr(tmp_path / "map.exr", image)
    assert not list(tmp_path.iterdir())


def test_folder_that_is_a_file(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(DappleError, match=r"Could not write .*map\.exr: .*choose another folder"):
        write_exr(tmp_path / "out" / "Floor" / "map.exr", np.zeros((4, 4, 3)))
    with pytest.raises(DappleError, match=r"Could not write .*bake\.json: .*choose another folder"):
        write_json(tmp_path / "out" / "bake.json", {})
    assert (tmp_path / "out").read_text() == "mine"


LIMITED = """
import resource, sys, types
package = types.ModuleType("dapple")
package.__path__ = [sys.argv[1]]
sys.modules["dapple"] = package
import numpy as np
from dapple.operators.errors import DappleError
from dapple.operators.maps.exr_file import is_whole
from dapple.operators.maps.write import write_exr, write_json
import bpy
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
images = len(bpy.data.images)
for write, path, content in (
    (write_exr, sys.argv[2] + "/map.exr", np.random.default_rng(1).random((64, 64, 3))),
    (write_json, sys.argv[2] + "/bake.json", {"long": list(range(20_000))}),
):
    try:
        write(path, content)
    except DappleError as error:
        print("DAPPLE", error)
assert len(bpy.data.images) == images
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits are POSIX")
@pytest.mark.bpy_module
def test_write_cut_short_leaves_the_old_file(tmp_path):
    write_exr(tmp_path / "map.exr", np.full((8, 8, 3), 0.25))
    write_json(tmp_path / "bake.json", {"old": True})
    command = [sys.executable, "-c", LIMITED, str(ROOT), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    said = [line for line in done.stdout.splitlines() if line.startswith("DAPPLE")]
    assert len(said) == 2
    assert all("Could not write" in line and "raise the limit" in line for line in said)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bake.json", "map.exr"]
    np.testing.assert_array_equal(read_exr(tmp_path / "map.exr"), np.full((8, 8, 3), 0.25))
    assert json.loads((tmp_path / "bake.json").read_text()) == {"old": True}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_full_disk_is_called_so(tmp_path, monkeypatch):
    def write(_path, content):
        with Path("/dev/full").open("wb", 0) as full:
            full.write(content)

    monkeypatch.setattr(Path, "write_bytes", write)
    with pytest.raises(DappleError, match="no space left on the disk; free some space or choose another folder"):
        write_json(tmp_path / "bake.json", {"a": 1})
    assert not list(tmp_path.iterdir())


def test_file_cut_anywhere_is_not_whole(tmp_path):
    write_exr(tmp_path / "map.exr", np.ones((20, 9, 3)))
    content = (tmp_path / "map.exr").read_bytes()
    assert is_whole(tmp_path / "map.exr")
    assert not is_whole(tmp_path / "missing.exr")
    for length in range(len(content)):
        (tmp_path / "cut.exr").write_bytes(content[:length])
        assert not is_whole(tmp_path / "cut.exr"), length


def test_file_whose_table_was_never_written_is_not_whole(tmp_path):
    write_exr(tmp_path / "map.exr", np.ones((40, 2, 3)))
    content = (tmp_path / "map.exr").read_bytes()
    table = content.index(b"screenWindowWidth\0float\0") + 24 + 4 + 4 + 1
    for entry in range(3):
        start = table + 8 * entry
        (tmp_path / "cut.exr").write_bytes(content[:start] + bytes(8) + content[start + 8 :])
        assert not is_whole(tmp_path / "cut.exr"), entry


def test_json_takes_what_a_bake_knows(tmp_path):
    record = {
        1: np.arange(3.0),
        "n": np.int64(4),
        "nan": np.float32("nan"),
        "path": Path("a"),
        "nested": ({"x": True},),
    }
    write_json(tmp_path / "bake.json", record)
    back = json.loads((tmp_path / "bake.json").read_text())
    assert back == {"1": [0, 1, 2], "n": 4, "nan": None, "path": "a", "nested": [{"x": True}]}


def test_folders_are_named_after_their_objects():
    assert map_path("out", "Pool Floor.001", 7) == Path("out/Pool Floor.001/caustics_0007.exr")
    awkward = ["a/b", "a:b", "..", ".", "", "nul.x", "tail ", "a\\b", "a\nb"]
    names = [folder_name(name) for name in awkward]
    assert len(set(names)) == len(awkward)
    assert all(name.strip(" .") == name and not set(name) & set("/\\:\n") and name for name in names)
