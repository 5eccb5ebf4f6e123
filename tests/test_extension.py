"""The extension's manifest and zips."""

import importlib.util
import shutil
import tomllib
import zipfile
from importlib.machinery import SourceFileLoader

import pytest

RUNS_IN_BLENDER = {"__init__.py", "blender_manifest.toml", "LICENSE", "README.md", "addon", "operators", "kernels"}
PLATFORMS = {"linux-x64": "x86_64", "windows-x64": "win_amd64", "macos-arm64": "arm64", "macos-x64": "x86_64"}


@pytest.fixture
def manifest(root):
    return tomllib.loads((root / "blender_manifest.toml").read_text())


def load_script(path):
    """A script of this repository as a module."""
    spec = importlib.util.spec_from_loader(path.stem, SourceFileLoader(path.stem, str(path)))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_wheel_for_every_platform_and_python(manifest):
    assert set(manifest["platforms"]) == set(PLATFORMS)
    tags = [wheel.removesuffix(".whl").split("-")[2:] for wheel in manifest["wheels"]]
    for platform, machine in PLATFORMS.items():
        system = {"linux": "manylinux", "windows": "win", "macos": "macosx"}[platform.split("-")[0]]
        for python in ("cp311", "cp313", "cp314"):
            fits = [tag for tag in tags if tag[0] == python and tag[2].startswith(system) and tag[2].endswith(machine)]
            assert len(fits) == 1, (platform, python)


def test_wheels_are_what_the_tests_run_with(root, manifest):
    versions = {wheel.split("-")[1] for wheel in manifest["wheels"]}
    assert {f"embreex=={version}" for version in versions} <= set(load_script(root / "dapple").PACKAGES)
    assert len(versions) == 1


@pytest.fixture
def tree(root, tmp_path):
    """A copy of what the extension is made of, without wheels, with the litter of a working tree around and in it."""
    tree = tmp_path / "tree"
    for name in ("addon", "operators", "kernels"):
        shutil.copytree(root / name, tree / name)
    for name in ("__init__.py", "LICENSE", "dapple"):
        shutil.copy(root / name, tree)
    text = (root / "blender_manifest.toml").read_text()
    start = text.index("wheels = [")
    (tree / "blender_manifest.toml").write_text(text[:start] + text[text.index("]\n", start) + 1 :])
    for name in (".venv/x.py", "tests/t.py", "notes.txt", "kernels/__pycache__/k.pyc", "addon/.swp", "wheels/old.whl"):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).touch()
    return tree


def test_zips_hold_what_runs_and_no_more(root, tree):
    dist = tree / "dist"
    assert load_script(root / ".ci" / "build.py").build(tree, dist) == 0
    zips = sorted(dist.glob("dapple-*.zip"))
    assert len(zips) == len(PLATFORMS)
    for path in zips:
        names = [name for name in zipfile.ZipFile(path).namelist() if not name.endswith("/")]
        assert {name.split("/")[0] for name in names} == RUNS_IN_BLENDER - {"README.md"}
        assert not [name for name in names if "__pycache__" in name or "/." in name]
        wanted = {f"kernels/{file.name}" for file in (root / "kernels").glob("*.py")}
        assert wanted <= set(names)


def test_build_says_when_the_manifest_is_wrong(root, tree):
    path = tree / "blender_manifest.toml"
    path.write_text(path.read_text().replace("\ntagline", "\ntag_line"))
    assert load_script(root / ".ci" / "build.py").build(tree, tree / "dist") != 0
