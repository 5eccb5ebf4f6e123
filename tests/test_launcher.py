"""The launcher, on copies of it in empty folders: what it makes, asks for, and says when it cannot go on."""

import importlib.util
import shutil
import subprocess
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

ENVIRONMENT = "whole", "no stamp", "old stamp", "no python"


def write_script(path, text):
    """An executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)


def load_launcher(path):
    """The launcher as a module."""
    spec = importlib.util.spec_from_loader("launcher", SourceFileLoader("launcher", str(path)))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def launcher(root, tmp_path):
    """A copy of the launcher, alone in a folder."""
    shutil.copy(root / "dapple", tmp_path / "dapple")
    return load_launcher(tmp_path / "dapple")


def make_fake_environment(launcher, state="whole"):
    """A .venv whose Python is a script that prints its arguments."""
    write_script(Path(launcher.PYTHON), 'echo "$@"\n')
    text = launcher.stamp_text((3, 13))
    if state != "no stamp":
        Path(launcher.STAMP).write_text(text.replace("embreex", "oldreex") if state == "old stamp" else text)
    if state == "no python":
        Path(launcher.PYTHON).unlink()


def start(launcher, *arguments):
    """Run the copy as a program."""
    command = [sys.executable, str(Path(launcher.ROOT) / "dapple"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("arguments", "code"), [([], 2), (["--help"], 0), (["frobnicate"], 2), (["--frob"], 2)])
def test_usage(launcher, arguments, code):
    run = start(launcher, *arguments)
    assert run.returncode == code
    assert (run.stderr if code else run.stdout).startswith("usage: dapple")
    assert not Path(launcher.VENV).exists()


def test_help_names_every_command(launcher):
    text = start(launcher).stderr
    assert all(f"\n    {name} " in text for name in launcher.COMMANDS)


@pytest.mark.parametrize("state", ENVIRONMENT)
def test_only_a_finished_environment_counts(launcher, state):
    make_fake_environment(launcher, state)
    assert launcher.is_whole() == (state == "whole")


def test_goes_straight_to_a_finished_environment(launcher):
    make_fake_environment(launcher)
    run = start(launcher, "test", "-k", "a b")
    assert run.returncode == 0
    assert run.stdout == f"-P {launcher.ROOT}/dapple test -k a b\n"


@pytest.fixture
def commands(launcher, monkeypatch):
    """What the launcher would run, with (3, 13) as its Python and nothing missing; none of it is run."""
    done = []

    def run(command, **_):
        done.append(command)
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(launcher, "find_python", lambda: ("/usr/bin/python3.13", (3, 13)))
    monkeypatch.setattr(launcher, "missing_packages", lambda python, version: [])
    return done


@pytest.mark.parametrize("state", ENVIRONMENT)
def test_environment_is_made_anew_unless_it_was_finished(launcher, commands, state):
    make_fake_environment(launcher, state)
    Path(launcher.VENV).mkdir(exist_ok=True)
    launcher.make_environment()
    assert [("--clear" in command) for command in commands if "venv" in command] == {
        "whole": [],
        "old stamp": [False],
    }.get(state, [True])
    assert Path(launcher.STAMP).read_text() == launcher.stamp_text((3, 13))


def test_an_environment_that_trees_share_is_brought_up_to_date_where_it_is(launcher, commands, root, tmp_path):
    make_fake_environment(launcher, "old stamp")
    tree = tmp_path / "tree"
    tree.mkdir()
    (tree / ".venv").symlink_to(launcher.VENV)
    shutil.copy(root / "dapple", tree / "dapple")
    other = load_launcher(tree / "dapple")
    other.find_python, other.missing_packages = launcher.find_python, launcher.missing_packages
    assert other.VENV == launcher.VENV
    other.make_environment()
    assert commands[0] == ["/usr/bin/python3.13", "-m", "venv", launcher.VENV]
    assert launcher.is_whole() and other.is_whole()


def test_another_blender_needs_a_new_environment(launcher, commands):
    make_fake_environment(launcher)
    Path(launcher.STAMP).write_text(launcher.stamp_text((3, 11)).replace("embreex", "oldreex"))
    launcher.make_environment()
    assert "--clear" in commands[0]


def test_another_blender_has_an_environment_of_its_own(root, tmp_path, monkeypatch):
    monkeypatch.setenv("DAPPLE_BPY", "4.2.23")
    shutil.copy(root / "dapple", tmp_path / "dapple")
    launcher = load_launcher(tmp_path / "dapple")
    assert str(tmp_path / ".venv-4.2.23") == launcher.VENV
    assert launcher.stamp_text((3, 11)).splitlines()[:2] == ["bpy==4.2.23", "numpy<2"]
    assert not launcher.is_whole()


def test_failed_install_leaves_no_stamp(launcher, commands, monkeypatch, capfd):
    make_fake_environment(launcher, "old stamp")
    monkeypatch.setattr(subprocess, "run", lambda command, **_: subprocess.CompletedProcess(command, "pip" in command))
    with pytest.raises(SystemExit) as end:
        launcher.make_environment()
    assert end.value.code == 1 and "-m pip install" in capfd.readouterr().err
    assert not Path(launcher.STAMP).exists()


def test_python_behind_a_shim_is_tried(launcher, tmp_path, monkeypatch):
    write_script(tmp_path / "bin" / "python3.11", "exit 127\n")
    write_script(tmp_path / "bin" / "python3.13", "exit 0\n")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(sys, "version_info", (3, 12, 1))
    assert launcher.find_python() == (str(tmp_path / "bin" / "python3.13"), (3, 13))


def test_no_fitting_python_is_said(launcher, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "version_info", (3, 12, 1))
    with pytest.raises(SystemExit) as end:
        launcher.find_python()
    assert end.value.code == 1 and "this is Python 3.12" in capfd.readouterr().err


def test_missing_packages_are_named(launcher, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    launcher.LIBRARIES = {"libc.so.6": ("libc6",), "libnot.so.1": ("not1", "not2"), "libnor.so.1": ("not2",)}
    write_script(tmp_path / "python", "exit 1\n")
    assert launcher.missing_packages(sys.executable, (3, 11)) == ["not1", "not2"]
    assert launcher.missing_packages(str(tmp_path / "python"), (3, 11)) == ["not1", "not2", "python3.11-venv"]


@pytest.fixture
def apt(tmp_path, monkeypatch):
    """A PATH with an apt-get and a sudo that only write down how they were called; gives their log."""
    log = tmp_path / "log"
    write_script(tmp_path / "bin" / "apt-get", f'echo "apt-get $*" >> {log}\n')
    write_script(tmp_path / "bin" / "sudo", f'echo "sudo $*" >> {log}; shift; exec "$@"\n')
    write_script(tmp_path / "bin" / "true", "")
    (tmp_path / "bin" / "env").symlink_to(shutil.which("env"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    return log


@pytest.mark.parametrize(("user", "prefix"), [(0, ""), (1000, "sudo -n env DEBIAN_FRONTEND=noninteractive ")])
def test_packages_are_installed(launcher, apt, monkeypatch, user, prefix):
    monkeypatch.setattr("os.geteuid", lambda: user)
    launcher.install_packages(["liba", "libb"])
    wanted = f"{prefix}apt-get -qq install -y --no-install-recommends liba libb"
    assert wanted in apt.read_text().splitlines()


def test_without_rights_the_command_is_said(launcher, apt, monkeypatch, capfd):
    write_script(apt.parent / "bin" / "sudo", "exit 1\n")
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    with pytest.raises(SystemExit) as end:
        launcher.install_packages(["liba", "libb"])
    last = capfd.readouterr().err.splitlines()[-1]
    assert end.value.code == 1 and not apt.exists()
    assert last == "sudo apt-get update && sudo apt-get install -y --no-install-recommends liba libb"


@pytest.mark.parametrize("script", ["exit 1\n", None], ids=["apt fails", "no apt"])
def test_what_cannot_be_installed_is_said(launcher, apt, monkeypatch, capfd, script):
    monkeypatch.setattr("os.geteuid", lambda: 0)
    (apt.parent / "bin" / "apt-get").unlink()
    if script:
        write_script(apt.parent / "bin" / "apt-get", script)
    with pytest.raises(SystemExit) as end:
        launcher.install_packages(["liba"])
    assert end.value.code == 1 and "liba" in capfd.readouterr().err


@pytest.mark.parametrize("arguments", [["gone.blend"], ["--frames", "1-2", "gone.blend"], ["gone.txt"]])
def test_bake_of_a_missing_file(launcher, capfd, arguments):
    with pytest.raises(SystemExit) as end:
        launcher.bake(arguments)
    assert end.value.code == 2 and f"no file {arguments[-1]}" in capfd.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["--frames", "1-2"]])
def test_bake_of_no_file(launcher, capfd, arguments):
    with pytest.raises(SystemExit) as end:
        launcher.bake(arguments)
    assert end.value.code == 2 and "SCENE.blend" in capfd.readouterr().err


@pytest.mark.parametrize("content", [b"", b"Dear Blender", b"BLENDER-v500"], ids=["empty", "text", "cut short"])
def test_bake_of_something_else(launcher, tmp_path, capfd, content):
    path = tmp_path / "letter.blend"
    path.write_bytes(content)
    with pytest.raises(SystemExit) as end:
        launcher.bake([str(path)])
    assert end.value.code == 2 and f"dapple: {path} cannot be opened" in capfd.readouterr().err
