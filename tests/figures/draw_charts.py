"""The charts of sample scenes: docs/images/chart_*.png, needs_*.png and docs/ladder_tables.md.

Run as `.venv/bin/python tests/figures/draw_charts.py`; it takes about ten minutes, and needs `mitsuba` from PyPI for
all that the charts hold (see `tests/bench/peers.py`).
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# scene -> texels along a map's side
SCENES = {"pool": 128, "calm_pond": 128, "ocean": 128, "lagoon": 128, "glass": 128}
ENOUGH = 1.3  # a choice that takes at most so many times as long as the front is as good as on it
CHOICES = "scene", "asked", "took", "CPU [s]", "error", "over the front's time", "over the quickest that meets it"
HEAD = "rung", "at", "CPU [s]", "error", "by squared mean", "MAE", "FLIP", "energy", "own estimate", ""


def command(name):
    """The words after ./dapple that make a scene's chart."""
    return ["chart", f"sample_blends/{name}.blend", "--frame", "2", "--resolution", str(SCENES[name]), "--peers"]


def table(name, known):
    """The lines of a scene's table, of its chart.json."""
    lines = [f"## {name}.blend", "", f"`./dapple {' '.join(command(name))}`", "", f"![](images/chart_{name}.png)", ""]
    lines += [f"![](images/needs_{name}.png)", ""]
    lines += [f"| {' | '.join(HEAD)} |", "|" + "---|" * len(HEAD)]
    for row in known["rows"]:
        marks = ["front"] * row["on_front"] + ["below the reference's error"] * row["below_floor"]
        if row["over_front"]:
            marks.append(f"{row['method']}, {row['over_front']:.2f} x the front's time")
        if row["seen"] < 1:
            marks.append(f"on {row['seen']:.0%} of the texels")
        cells = [row["rung"], row["label"], f"{row['seconds']:.3f}", f"{row['error']:.1e}", f"{row['by_mean']:.1e}"]
        cells += [f"{row['mae']:.3f}", "" if row["flip"] is None else f"{row['flip']:.3f}", f"{row['energy']:+.2%}"]
        cells += ["" if row["estimated"] is None else f"{row['estimated']:.1e}", "; ".join(marks)]
        lines.append(f"| {' | '.join(cells)} |")
    truth = known["reference"]
    of = f"Reference: error {truth['error']:.1e}, flux within {truth['flux_error']:.0e}"
    return [*lines, "", of + (f", 2 x {truth['suns']} suns." if truth["suns"] else "."), *known["notes"], ""]


def choices(known):
    """Lines on what the planner took on each scene, of their chart.json."""
    found = [(name, row) for name, own in known.items() for row in own["rows"] if row["over_front"] is not None]
    good = sum(row["over_front"] <= ENOUGH for _, row in found)
    met = sum(row["error"] <= row["asked"] for _, row in found)
    lines = [f"*Automatic* is on the front, or within {ENOUGH} of it in time, with {good} of {len(found)} choices; its"]
    lines += [f"error is within what was asked with {met}. Where no other run is as good, the last but one is 0.", ""]
    lines += [f"| {' | '.join(CHOICES)} |", "|" + "---|" * len(CHOICES)]
    for name, row in found:
        own = (r for r in known[name]["rows"] if r["over_front"] is None and not r["peer"])
        within = [r for r in own if r["error"] <= row["asked"]]
        least = min(within, key=lambda r: r["seconds"], default=None)
        cells = [name, f"{row['label']}: {row['asked']:g}", row["method"], f"{row['seconds']:.3f}"]
        cells += [f"{row['error']:.1e}", f"{row['over_front']:.2f}"]
        cells.append(f"{row['seconds'] / least['seconds']:.2f}: {least['rung']}, {least['label']}" if least else "")
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, ""]


def write(folder):
    """Put the charts that lie in folder/SCENE into docs."""
    known = {name: json.loads((folder / name / "chart.json").read_text()) for name in SCENES}
    first = known["pool"]
    versions = ", ".join(f"{key} {value}" for key, value in first["versions"].items())
    lines = [f"Measured on {first['date']} by `.venv/bin/python tests/figures/draw_charts.py`: {first['machine']}, one"]
    lines += [f"core; {versions}. [What the columns say](ladder.md#the-chart).", ""]
    lines += choices(known)
    for name, own in known.items():
        for kind in ("chart", "needs"):
            shutil.copy(folder / name / f"{kind}.png", ROOT / "docs" / "images" / f"{kind}_{name}.png")
        lines += table(name, own)
    (ROOT / "docs" / "ladder_tables.md").write_text("\n".join(lines))


def main():
    """Make and write all of them."""
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            subprocess.run([str(ROOT / "dapple"), *command(name), "--out", f"{folder}/{name}"], cwd=ROOT, check=True)
        write(Path(folder))


if __name__ == "__main__":
    sys.exit(main())
