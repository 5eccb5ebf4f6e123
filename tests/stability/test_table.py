"""The table in docs knows every construction of this folder, and none of its cells is wrong in silence."""

import ast
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def constructions():
    """First line of the docstring of every test that fills a row of the table."""
    for path in sorted(HERE.glob("test_*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            arguments = {a.arg for a in node.args.args} if isinstance(node, ast.FunctionDef) else set()
            if {"row", "every_method"} & arguments and node.name.startswith("test_"):
                yield ast.get_docstring(node).splitlines()[0].rstrip(".")


@pytest.fixture
def table(root):
    return (root / "docs" / "stability.md").read_text(encoding="utf-8")


def test_the_table_names_every_construction(table):
    names = list(constructions())
    assert len(names) > 40
    missing = [name for name in names if f"| {name} " not in table]
    assert not missing, f"{missing}: run ./dapple test tests/stability --stability-table docs/stability.md"


def test_no_cell_is_wrong(table):
    rows = [line for line in table.splitlines() if line.startswith("| ")]
    assert len(rows) > 60 and "right" in table
    assert not [line for line in rows if "**wrong**" in line]
