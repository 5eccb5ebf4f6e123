"""From a scene to chart.png, chart.csv and chart.json, by the operator and by the command."""

import csv
import io
import json

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from dapple.kernels.chart.chart import Row  # noqa: E402
from dapple.operators import cli  # noqa: E402
from dapple.operators.bake.bake import request_from_scene  # noqa: E402
from dapple.operators.chart.make import chart  # noqa: E402
from dapple.operators.chart.record import COLUMNS, table  # noqa: E402
from dapple.tests.blender.small_pool import build_pool, files_in  # noqa: E402

FILES = ["chart.csv", "chart.json", "chart.png"]


@pytest.fixture
def pool(empty_scene, tmp_path):
    build_pool(empty_scene, tmp_path / "out")
    bpy.data.lights["Sun"].angle = 0.0
    return empty_scene


def test_a_scene_from_end_to_end(pool, tmp_path, capsys):
    words = ["chart", "--frame", "2", "--rungs", "flat,photon_splat,auto", "--resolution", "16"]
    assert cli.main([*words, "--out", str(tmp_path / "here")]) == 0
    assert files_in(tmp_path / "here") == FILES
    assert pool.frame_current == 1
    lines = capsys.readouterr().out.splitlines()
    assert len(set(lines)) == len(lines)
    assert sum(line.startswith("photon_splat, 0.") for line in lines) == 6
    assert str(tmp_path / "here" / "chart.png") in lines[-1]
    known = json.loads((tmp_path / "here" / "chart.json").read_text())
    assert (known["frame"], known["settings"]["resolution"]) == (2, 16)
    assert known["command"].endswith("--frame 2 --resolution 16")
    assert known["machine"]
    assert known["versions"]["Blender"] == bpy.app.version_string
    assert 0 <= known["reference"]["error"] < 1e-6
    rows = list(csv.DictReader(io.StringIO((tmp_path / "here" / "chart.csv").read_text())))
    assert [row["rung"] for row in rows] == [row["rung"] for row in known["rows"]]
    by = {(row["rung"], row["label"]): row for row in rows}
    # The water is still: the closed form is exact.
    assert float(by["flat", "still water"]["error"]) < 1e-6
    assert float(by["flat", "still water"]["energy"]) == pytest.approx(0, abs=1e-4)
    assert by["auto", "Preview"]["method"] in ("flat", "photon_splat")
    assert (tmp_path / "here" / "chart.png").read_bytes()[:4] == b"\x89PNG"


def test_peers_join_and_are_named(pool, tmp_path):
    def peer(scene, settings, texels):
        light = np.zeros((sum(len(own.texel) for own in texels), 3))
        yield "peer: looking", None
        known = {"rung": "peer", "label": "dark", "method": "peer", "asked": None, "seconds": 1.0, "runs": 1}
        yield "peer: dark", {**known, "light": light, "seen": None}

    words = ["chart", "--frame", "2", "--rungs", "flat", "--resolution", "16", "--out", str(tmp_path / "here")]
    assert cli.main(words, (peer,)) == 0
    known = json.loads((tmp_path / "here" / "chart.json").read_text())
    assert known["command"].endswith("--resolution 16 --peers")
    assert [(row["rung"], row["energy"]) for row in known["rows"] if row["peer"]] == [("peer", -1.0)]
    flips = [row["flip"] for row in sorted(known["rows"], key=lambda row: row["error"])]
    assert flips == [None, None] or 0 <= flips[0] < flips[1]  # flat, dark


def test_what_is_stopped_leaves_nothing(pool, tmp_path):
    request = request_from_scene(pool, frames=(3,))
    steps = chart(bpy.context, request, ("photon_splat",))
    said = next(steps)
    while not said.startswith("photon_splat"):
        said = next(steps)
    steps.close()
    assert files_in(tmp_path) == []
    assert pool.frame_current == 1


def test_a_scene_that_cannot_be_measured(pool, tmp_path, capsys):
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    assert cli.main(["chart"]) == 1
    assert capsys.readouterr().err.startswith("dapple: The scene has no lamp that renders")
    assert cli.main(["chart", "--rungs", "magic"]) == 1
    assert "There is no rung 'magic'" in capsys.readouterr().err
    with pytest.raises(RuntimeError, match="no lamp"):
        bpy.ops.dapple.chart()
    assert files_in(tmp_path) == []


def test_the_button_says_why_it_is_grey(pool):
    assert bpy.ops.dapple.chart.poll()
    bpy.context.window_manager.dapple.begin()
    assert not bpy.ops.dapple.chart.poll()
    bpy.context.window_manager.dapple.end()
    pool.dapple.receivers = None
    assert not bpy.ops.dapple.chart.poll()


def test_the_table_holds_what_rows_hold():
    row = Row("a, b", "x", "m", None, 0.5, 3, 0.25, 0.125, 0.1, -0.01, reason='say "so"', on_front=True)
    (read,) = csv.DictReader(io.StringIO(table([row])))
    assert tuple(read) == COLUMNS
    assert (read["rung"], read["reason"], read["asked"], read["flip"]) == ("a, b", 'say "so"', "", "")
    assert (float(read["seconds"]), float(read["energy"]), read["on_front"]) == (0.5, -0.01, "True")
