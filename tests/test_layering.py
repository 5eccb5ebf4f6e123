"""The code flows one way: addon -> operators -> kernels, and kernels knows no Blender.

Every rule is shown to catch a small source that breaks it, so that a rule which has gone blind fails here.
"""

import ast
import subprocess
import sys

import pytest

LAYERS = ("kernels", "operators", "addon")
BLENDER = {"bpy", "bpy_extras", "bmesh", "mathutils", "gpu", "blf"}
RAYS = "kernels/rays.py"


def imported_names(source, path):
    """Yield the dotted names that a module imports; those of this tree start with a layer, or "" for its root."""
    package = path.split("/")[:-1]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level]
            outside = ["<outside>"] if node.level > len(package) + 1 else []
            base = outside + base + (node.module.split(".") if node.module else [])
            yield from (".".join([*base, alias.name]) for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if called in ("__import__", "import_module"):
                yield str(node.args[0].value).lstrip(".")


def breach(name, path):
    """What is wrong with the module at `path` importing `name`, or None."""
    layer, head = path.split("/")[0], name.split(".")[0]
    if head in ("dapple", "bl_ext", "<outside>"):
        return "imports by the package's name; use a relative import"
    if head in LAYERS and LAYERS.index(head) > LAYERS.index(layer):
        return f"imports {head}, which is above {layer}"
    if head == "embreex" and path != RAYS:
        return f"imports embreex, which only {RAYS} may"
    if layer == "kernels" and head in BLENDER:
        return "imports Blender"
    if layer == "kernels" and head not in {*sys.stdlib_module_names, "numpy", "embreex", "kernels"}:
        return f"imports {head}, which Blender does not have"
    return None


def breaches(source, path):
    """The sentences on every import of a source that breaks the flow; `path` is relative to the root."""
    found = ((name, breach(name, path)) for name in imported_names(source, path))
    return [f"{path}: {name}: {problem}" for name, problem in found if problem]


def sources(root, layer):
    """The files of a layer, as (path relative to the root, source)."""
    return [(file.relative_to(root).as_posix(), file.read_text()) for file in sorted((root / layer).rglob("*.py"))]


@pytest.mark.parametrize("layer", LAYERS)
def test_layer_imports_only_what_is_below(root, layer):
    files = sources(root, layer)
    assert files, f"no modules found in {layer}"
    assert [line for path, source in files for line in breaches(source, path)] == []


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("kernels/a.py", "import bpy"),
        ("kernels/a.py", "import numpy as np, bpy.types"),
        ("kernels/a.py", "def f():\n    from mathutils import Vector"),
        ("kernels/a.py", "if True:\n    import importlib\n    importlib.import_module('bpy')"),
        ("kernels/a.py", "__import__('bpy')"),
        ("kernels/a.py", "import scipy.sparse"),
        ("kernels/a.py", "from .. import operators"),
        ("kernels/a.py", "from ..addon.panels import X"),
        ("kernels/deep/a.py", "from ...operators import bake"),
        ("kernels/a.py", "from ... import other"),
        ("kernels/a.py", "from embreex import rtcore_scene"),
        ("operators/a.py", "import embreex"),
        ("operators/a.py", "from ..addon import properties"),
        ("operators/a.py", "from .. import addon"),
        ("operators/a.py", "from dapple.kernels import scene"),
        ("addon/a.py", "import dapple"),
    ],
)
def test_rule_catches(path, source):
    assert len(breaches(source, path)) == 1


@pytest.mark.parametrize(
    ("path", "source"),
    [
        ("kernels/rays.py", "from embreex import rtcore_scene"),
        ("kernels/a.py", "from __future__ import annotations\nimport math\nimport numpy as np\nfrom . import scene"),
        ("kernels/deep/a.py", "from ..scene import Water\nfrom .. import status"),
        ("operators/a.py", "import bpy\nfrom ..kernels.scene import Settings\nfrom .errors import DappleError"),
        ("addon/a.py", "import bpy\nfrom ..operators import ops_bake\nfrom ..kernels import methods"),
    ],
)
def test_rule_lets_pass(path, source):
    assert breaches(source, path) == []


IMPORT_KERNELS = """
import importlib, pkgutil, runpy, sys
runpy.run_path({conftest!r})
import dapple.kernels
for module in pkgutil.walk_packages(dapple.kernels.__path__, "dapple.kernels."):
    importlib.import_module(module.name)
{extra}
print(len([name for name in sys.modules if name.startswith("dapple.kernels.")]))
print(sorted({{"bpy", "mathutils", "dapple.addon", "dapple.operators"}} & set(sys.modules)))
"""


def loaded_with_kernels(root, extra=""):
    """How many kernels a fresh interpreter imports, and which forbidden modules are then loaded."""
    code = IMPORT_KERNELS.format(conftest=str(root / "tests" / "conftest.py"), extra=extra)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    count, forbidden = run.stdout.splitlines()[-2:]
    return int(count), forbidden


def test_kernels_run_without_blender(root):
    count, forbidden = loaded_with_kernels(root)
    assert count >= len(list((root / "kernels").glob("[!_]*.py"))) > 0
    assert forbidden == "[]"


def test_a_loaded_blender_is_noticed(root):
    assert loaded_with_kernels(root, "sys.modules['bpy'] = sys")[1] == "['bpy']"


@pytest.mark.parametrize("command", [["check"], ["format", "--check", "--diff"]], ids=["check", "format"])
def test_ruff_is_content(root, command):
    run = subprocess.run([sys.executable, "-m", "ruff", *command, "."], cwd=root, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize(
    ("command", "source"),
    [
        (["check"], "import os\n"),
        (["check"], "x = '" + "a" * 120 + "'\n"),
        (["format", "--check"], "x = 'single'\n"),
    ],
)
def test_ruff_minds(root, tmp_path, command, source):
    (tmp_path / "bad.py").write_text(source)
    config = ["--config", str(root / "pyproject.toml"), "--no-cache"]
    run = subprocess.run([sys.executable, "-m", "ruff", *command, *config, str(tmp_path)], capture_output=True)
    assert run.returncode == 1
