"""What the documents name is there: links, pictures, files, commands and their options."""

import re

import pytest

PAGES = "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md"
OWN = "kernels", "operators", "addon", "tests", "docs", "sample_blends", ".ci"
COMMANDS = {"bake", "export", "chart"}
OTHERS = {"--command", "--factory-startup", "--help"}  # options of Blender and of argparse


def documents(root):
    """Path and text of every page."""
    return [(path, path.read_text()) for pattern in PAGES for path in sorted(root.glob(pattern))]


def without_code(text):
    """The text of a page less its blocks and spans of code."""
    return re.sub(r"`[^`\n]*`", "", re.sub(r"```.*?```", "", text, flags=re.DOTALL))


def code(text):
    """The lines of a page's blocks of code, without remarks, and its spans of code."""
    blocks = re.findall(r"```\w*\n(.*?)```", text, re.DOTALL)
    lines = [line.split("  #")[0] for block in blocks for line in block.splitlines()]
    return lines + [
        " ".join(span.split()) for span in re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", text, flags=re.S))
    ]


def links(text):
    """The relative targets of a page's links and pictures."""
    found = re.findall(r"\]\(([^)\s]+)\)", without_code(text))
    return [target for target in found if not re.match(r"[a-z]+:", target)]


def anchors(text):
    """What links can name in a page: its headings, as GitHub spells them."""
    headings = re.findall(r"^#+ (.+)$", without_code(text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def broken_links(path, text):
    """The links of a page that lead nowhere."""
    broken = []
    for target in links(text):
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        if not file.exists() or (anchor and anchor not in anchors(file.read_text())):
            broken.append(f"{path.name}: {target}")
    return broken


def missing_files(root, text):
    """The paths of this tree that a text names and that are not there, but for those that git ignores."""
    ignored = [line.rstrip("/") for line in (root / ".gitignore").read_text().split()]
    heads = "|".join(map(re.escape, OWN))
    named = {
        path.rstrip("./,:") for word in code(text) for path in re.findall(rf"(?<![\w/.<])(?:{heads})/[\w./-]+", word)
    }
    return sorted(p for p in named if not (root / p).exists() and p not in ignored and "_caustics" not in p)


def commands(text):
    """The commands of the launcher and of Blender that a text names: (command, options)."""
    found = []
    for line in code(text):
        match = re.search(r"(?:\./dapple|--command dapple) ([a-z]+)(.*)", line)
        if match:
            found.append((match[1], set(re.findall(r"--[a-z][a-z-]+", match[2]))))
    return found


def test_links_lead_somewhere(root):
    pages = documents(root)
    assert len(pages) > 20
    assert [line for path, text in pages for line in broken_links(path, text)] == []


def test_every_picture_is_shown(root):
    shown = {(path.parent / target).resolve() for path, text in documents(root) for target in links(text)}
    assert [picture.name for picture in (root / "docs" / "images").iterdir() if picture not in shown] == []


def test_readme_lists_every_page_once(root):
    """Tables are listed by the pages that they belong to."""
    entries = re.findall(r"^- .*?(?=^- |^$)", (root / "README.md").read_text(), re.MULTILINE | re.DOTALL)
    listed = sorted(target for entry in entries for target in links(entry) if target.startswith("docs/"))
    texts = [text for _, text in documents(root)]
    tables = {
        f"docs/{p.name}" for p in (root / "docs").glob("*.md") if p.read_text().startswith(("Measured", "# Workers"))
    }
    assert listed == sorted({f"docs/{page.name}" for page in (root / "docs").glob("*.md")} - tables)
    assert [page for page in tables if not any(f"({page.removeprefix('docs/')}" in text for text in texts)] == []


def test_files_that_are_named_are_there(root):
    missing = {path.name: missing_files(root, text) for path, text in documents(root)}
    assert {name: files for name, files in missing.items() if files} == {}


@pytest.fixture
def options(root, capsys):
    """Every option of each command, as its help tells."""
    pytest.importorskip("bpy")
    from dapple.operators import cli

    found = {}
    for command in COMMANDS:
        assert cli.main([command, "--help"]) == 0
        found[command] = {*re.findall(r"--[a-z][a-z-]+", capsys.readouterr().out), "--help"}
    found["chart"].add("--peers")  # the launcher's own, since it is for source trees
    return found


def test_commands_and_their_options_exist(root, options):
    conftests = "".join(path.read_text() for path in (root / "tests").rglob("conftest.py"))
    named = [(path.name, *command) for path, text in documents(root) for command in commands(text)]
    assert len(named) > 10
    for page, command, words in named:
        if command == "test":
            assert all(f'"{word}"' in conftests for word in words), (page, words)
        elif command != "build":
            assert words <= options[command], (page, command, words - options[command])


def test_options_in_prose_exist(root, options):
    """A span of code that begins with an option means one of Dapple's."""
    known = OTHERS.union(*options.values())
    for path, text in documents(root):
        words = {word for span in code(text) for word in re.findall(r"^--[a-z][a-z-]+", span)}
        assert words <= known, (path.name, words - known)


def test_scripts_know_their_options(root):
    for path, text in documents(root):
        for script, rest in re.findall(r"(tests/[\w/]+\.py)([^\n`]*)", "\n".join(code(text))):
            source = (root / script).read_text()
            for word in re.findall(r" (--[a-z][a-z-]+)", rest):
                assert f'"{word}"' in source, (path.name, script, word)


def test_wrong_words_are_noticed(root, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# A page\n[gone](gone.md) ![](gone.png) [no](#no-such) [yes](#a-page) `tests/gone.py`\n")
    assert len(broken_links(page, page.read_text())) == 3
    assert missing_files(root, page.read_text()) == ["tests/gone.py"]
    assert commands("`./dapple bake A.blend --gone`") == [("bake", {"--gone"})]
