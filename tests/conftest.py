"""Make the working tree importable as the package `dapple`, whatever its folder is called."""

import importlib.util
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def _register_package():
    """Put the tree into sys.modules as `dapple`; imports no Blender."""
    spec = importlib.util.spec_from_file_location(
        "dapple", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules["dapple"] = package
    spec.loader.exec_module(package)


if "dapple" not in sys.modules:
    _register_package()


@pytest.fixture(scope="session")
def root() -> Path:
    """The folder of the working tree."""
    return ROOT
