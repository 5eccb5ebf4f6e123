"""The command's words, what it prints, and what its exit code promises."""

import json

import bpy
import pytest

from dapple.operators import cli
from dapple.tests.blender.exr_reader import read_exr
from dapple.tests.blender.small_pool import add_grid, build_pool, files_in, solve_by_height, use_solver


@pytest.fixture
def pool(empty_scene, tmp_path, monkeypatch):
    build_pool(empty_scene, tmp_path / "out")
    use_solver(monkeypatch, solve_by_height)
    return empty_scene


def test_scene_says_all(pool, tmp_path, capsys):
    assert cli.main(["bake"]) == 0
    maps = [f"Floor/caustics_{n:04d}.exr" for n in (1, 2, 3)]
    assert files_in(tmp_path / "out") == [*maps, "bake.json"]
    lines = capsys.readouterr().out.splitlines()
    said = [line for line in lines if line.startswith("[")]
    assert [line.split("]")[0] for line in said] == ["[1/3", "[2/3", "[3/3"]
    assert all("by_height" in line and "75.0% received" in line for line in said)
    assert str(tmp_path / "out") in lines[-1]


def test_words_override_the_scene(pool, tmp_path, monkeypatch):
    pool.dapple.water = pool.dapple.receivers = None
    pool.dapple.output = "//"
    for name, z in (("Sea", 3.0), ("Bay", 3.0), ("Reef", -1.0), ("Sand", -2.0)):
        add_grid(name, z)
    monkeypatch.chdir(tmp_path)
    words = ["bake", "--frames", "2-3,9", "--method", "conic_walk", "--tolerance", "0.2", "--resolution", "32"]
    words += ["--dispersion", "55.7", "--match-cycles", "--bounces", "4", "--out", "here"]
    words += ["--water", "Sea,Bay", "--receivers", "Reef, Sand"]
    assert cli.main(words) == 0
    known = json.loads((tmp_path / "here" / "bake.json").read_text())
    assert known["water"] == ["Sea", "Bay"]
    assert known["receivers"] == ["Reef", "Sand"]
    assert list(known["frames"]) == ["2", "3", "9"]
    settings = known["settings"]
    assert (settings["method"], settings["tolerance"], settings["resolution"]) == ("conic_walk", 0.2, 32)
    assert (settings["dispersion"], settings["match_cycles"]) == (55.7, True)
    assert (settings["bounces"], settings["padding"]) == (4, 4)
    assert len(files_in(tmp_path / "here")) == 7


@pytest.mark.parametrize(
    ("words", "size"), [(["--texels-per-metre", "10"], 32), (["--resolution", "64"], 64), ([], 48)]
)
def test_texels_per_metre_or_a_resolution(pool, tmp_path, words, size):
    """The word takes the place of the scene's 20 texels on a metre of a floor of 2 m."""
    pool.dapple.texels_per_metre = 20.0
    assert cli.main(["bake", "--frames", "1", "--out", str(tmp_path / "here"), *words]) == 0
    assert read_exr(tmp_path / "here/Floor/caustics_0001.exr").shape[:2] == (size, size)


def test_texels_per_metre_that_are_none_are_told(pool, capfd):
    assert cli.main(["bake", "--texels-per-metre", "-3"]) == 1
    assert "-3 texels per metre are out of range" in capfd.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["bake", "--frames", "5-1"],
        ["bake", "--frames", "1,,2"],
        ["bake", "--frames", "one"],
        ["bake", "--method", "magic"],
        ["bake", "--resolution", "big"],
        ["bake", "--resolution", "64", "--texels-per-metre", "20"],
        ["bake", "--water", ","],
        ["bake", "--speed", "9"],
    ],
)
def test_words_that_make_no_sense(pool, tmp_path, words, capsys):
    assert cli.main(words) == 2
    assert "usage: dapple" in capsys.readouterr().err
    assert files_in(tmp_path) == []


def test_help_is_no_error(pool, capsys):
    assert cli.main(["bake", "--help"]) == 0
    assert "--receivers" in capsys.readouterr().out


def test_warning_is_said_once(pool, capsys):
    panel = bpy.data.objects.new("Panel", bpy.data.lights.new("Panel", "AREA"))
    pool.collection.objects.link(panel)
    panel.scale.x = 0.0
    assert cli.main(["bake"]) == 0
    assert capsys.readouterr().err.count("warning: Lamp 'Panel' has no area") == 1


def test_scene_that_cannot_be_baked(pool, capsys):
    bpy.data.objects.remove(bpy.data.objects["Sun"])
    assert cli.main(["bake"]) == 1
    error = capsys.readouterr().err
    assert error.startswith("dapple: Frame 1: The scene has no lamp that renders")
    assert "Traceback" not in error


def test_map_that_vanished_is_no_success(pool, tmp_path, monkeypatch, capsys):
    def solve(scene, texels, settings, kept):
        if pool.frame_current == 3:
            (tmp_path / "out/Floor/caustics_0001.exr").unlink()
        return solve_by_height(scene, texels, settings)

    use_solver(monkeypatch, solve)
    assert cli.main(["bake"]) == 1
    error = capsys.readouterr().err
    assert "1 maps are not on disk and whole" in error
    assert "caustics_0001.exr" in error


def test_interrupt_keeps_frames(pool, tmp_path, monkeypatch, capsys):
    def solve(scene, texels, settings, kept):
        if pool.frame_current == 2:
            raise KeyboardInterrupt
        return solve_by_height(scene, texels, settings)

    use_solver(monkeypatch, solve)
    assert cli.main(["bake"]) == 1
    assert "stopped; the finished frames are kept" in capsys.readouterr().err
    assert files_in(tmp_path / "out") == ["Floor/caustics_0001.exr", "bake.json"]


def test_a_preset_is_a_tolerance(capsys):
    for name, tolerance in (("draft", 5e-2), ("Preview", 1e-2), ("FINAL", 1e-3)):
        assert cli._parser(()).parse_args(["bake", "--preset", name]).tolerance == tolerance
    assert cli.main(["bake", "--preset", "finest"]) == 2
    assert cli.main(["bake", "--preset", "final", "--tolerance", "0.1"]) == 2
    assert "expected draft, preview or final" in capsys.readouterr().err
