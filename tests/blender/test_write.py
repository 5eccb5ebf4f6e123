"""What is read back is what was written, and a disk that fails leaves what there was."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest

from dapple.operators.errors import DappleError
from dapple.operators.exr_file import is_whole
from dapple.operators.write import folder_name, map_path, write_exr, write_json

ROOT = Path(__file__).parents[2]


def read_exr(path):
    """(H,W,3) float32, row 0 at the bottom, by OpenEXR's own reader."""
    channels = OpenEXR.File(str(path)).channels()
    assert list(channels) == ["RGB"]
    return channels["RGB"].pixels[::-1]


def test_values_and_orientation_are_kept(tmp_path):
    image = np.random.default_rng(7).lognormal(0.0, 3.0, (16, 24, 3)).astype(np.float32)
    image[0, 0], image[0, 1], image[15, 0] = 0.5, (0.0, 1e-6, 30.0), 7.0
    write_exr(tmp_path / "new" / "map.exr", image.astype(float))
    back = read_exr(tmp_path / "new" / "map.exr")
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, image)


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
from dapple.operators.exr_file import is_whole
from dapple.operators.write import write_exr, write_json
import bpy
resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
images = len(bpy.data.images)
for write, path, content in (
    (write_exr, sys.argv[2] + "/map.exr", np.ones((64, 64, 3))),
    (write_json, sys.argv[2] + "/bake.json", {"long": list(range(20_000))}),
):
    try:
        write(path, content)
    except DappleError as error:
        print("DAPPLE", error)
assert len(bpy.data.images) == images
"""


@pytest.mark.skipif(sys.platform == "win32", reason="limits are POSIX")
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
    monkeypatch.setattr(Path, "write_text", lambda path, text, encoding: Path("/dev/full").write_bytes(text.encode()))
    with pytest.raises(DappleError, match="no space left on the disk; free some space or choose another folder"):
        write_json(tmp_path / "bake.json", {"a": 1})
    assert not list(tmp_path.iterdir())


def test_file_cut_anywhere_is_not_whole(tmp_path):
    write_exr(tmp_path / "map.exr", np.ones((3, 2, 3)))
    content = (tmp_path / "map.exr").read_bytes()
    assert is_whole(tmp_path / "map.exr")
    assert not is_whole(tmp_path / "missing.exr")
    for length in range(len(content)):
        (tmp_path / "cut.exr").write_bytes(content[:length])
        assert not is_whole(tmp_path / "cut.exr"), length


def test_file_whose_table_was_never_written_is_not_whole(tmp_path):
    write_exr(tmp_path / "map.exr", np.ones((3, 2, 3)))
    content = (tmp_path / "map.exr").read_bytes()
    table = len(content) - 3 * (8 + 2 * 12) - 3 * 8
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
