"""What docs/troubleshooting.md quotes is what the add-on says."""

import ast
import re

import pytest

LEAST = 12  # letters: shorter pieces between "..." could stand anywhere


def sentences(root):
    """All texts of the operators, names and numbers in them as "...", joined where the source splits them."""
    found = []
    for path in sorted((root / "operators").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(re.sub(r"\{[^}]*\}", "...", node.value))
            elif isinstance(node, ast.JoinedStr):
                parts = (v.value if isinstance(v, ast.Constant) else "..." for v in node.values)
                found.append("".join(parts))
    return found


def quotes(root):
    """The quoted messages, without what only names a thing of the interface."""
    text = (root / "docs" / "troubleshooting.md").read_text()
    return [quote for quote in re.findall(r"`([^`]+)`", text) if len(quote.split()) > 4]


def is_said(quote, said):
    """Whether the pieces of a quote between "..." stand in this order in one text."""
    pieces = [piece.strip() for piece in quote.split("...") if len(piece.strip()) >= LEAST]
    pattern = ".*".join(map(re.escape, pieces))
    return bool(pieces) and any(re.search(pattern, text, re.DOTALL) for text in said)


def test_every_quote_is_said(root):
    said = sentences(root)
    wrong = [quote for quote in quotes(root) if not is_said(quote, said)]
    assert wrong == [] and len(quotes(root)) > 15


@pytest.mark.parametrize(
    "quote", ["There are no receivers; buy a collection", "...", "Object '...' is both, alas, now"]
)
def test_a_wrong_quote_is_noticed(root, quote):
    assert not is_said(quote, sentences(root))
