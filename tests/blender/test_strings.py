"""Everything that a person reads in the panel is a plain literal, so that Blender's translations find it."""

import ast
from pathlib import Path

import bpy
import pytest

ROOT = Path(__file__).parents[2]
FILES = [*sorted((ROOT / "addon").glob("*.py")), *sorted((ROOT / "operators").rglob("ops_*.py"))]
READ = {"name", "description", "text", "heading"}  # keywords of properties and of layouts
LABELS = {"bl_label", "bl_description"}


def strings(tree):
    """(line, node) of every label, name and description in a module, but texts that are marked as not translated."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in LABELS:
            yield node.lineno, node.value
        if isinstance(node, ast.Call):
            words = {keyword.arg: keyword.value for keyword in node.keywords}
            if "translate" not in words:
                yield from ((node.lineno, words[word]) for word in READ & words.keys())


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_labels_are_literals(path):
    # Names of objects, and counts, are no words to translate.
    made = {"name", "status"}
    for line, node in strings(ast.parse(path.read_text())):
        plain = isinstance(node, ast.Constant) and isinstance(node.value, str)
        assert plain or getattr(node, "id", "") in made or isinstance(node, ast.Attribute), f"{path.name}:{line}"


def test_there_is_something_to_check():
    found = [node for path in FILES for _, node in strings(ast.parse(path.read_text()))]
    assert sum(isinstance(node, ast.Constant) for node in found) > 60


def properties():
    for group in (bpy.types.Scene.bl_rna, bpy.types.Object.bl_rna):
        yield from (
            p for p in group.properties["dapple"].fixed_type.properties if p.identifier not in ("rna_type", "name")
        )


def test_all_that_can_be_hovered_is_explained(empty_scene):
    """As Blender has it: a name, and a description without a full stop at its end."""
    for prop in properties():
        assert prop.name and len(prop.description) > 10 and not prop.description.endswith("."), prop.identifier
        for item in getattr(prop, "enum_items", ()):
            assert item.description and not item.description.endswith("."), item.identifier
    for name in dir(bpy.ops.dapple):
        button = getattr(bpy.ops.dapple, name).get_rna_type()
        assert button.name and len(button.description) > 10 and not button.description.endswith("."), name


def test_operators_are_found_by_search_and_undo_what_changes_the_file(empty_scene):
    changing = {"attach", "detach", "choose", "lightmap_uvs", "live_preview", "look_through", "show_status"}
    for name in dir(bpy.ops.dapple):
        options = getattr(bpy.ops.dapple, name).bl_options
        assert "INTERNAL" not in options, name
        assert ("UNDO" in options) == (name in changing), name
