"""chart.csv, chart.json, chart.png and needs.png: the rows, all that was said, and the pictures."""

from __future__ import annotations

import csv
import io
import platform
import time
from dataclasses import asdict, fields
from importlib import metadata
from pathlib import Path

import bpy
import numpy as np

from ...kernels.chart.chart import Row
from ..maps.write import write_file, write_json, write_text
from .flip import MISSING, flip
from .needs_picture import draw as draw_needs
from .picture import draw

VERSION = 1
_OTHERS = "Squares: other renderers, on the same surfaces"
_SMOOTH = ": the smooth water of the reference, which is made for them beforehand"
COLUMNS = tuple(field.name for field in fields(Row))


def written(request, number, scene, chart, warnings):
    """Write a Chart of a frame of a Scene; returns the Paths of its picture, its table and its record."""
    notes = [*chart.notes, *([] if flip() else [MISSING])]
    title = f"{_name()}, frame {number}: how good each method is, and how long it takes"
    record = {
        "version": VERSION,
        "date": time.strftime("%Y-%m-%d"),
        "file": _name(),
        "frame": number,
        "command": _command(request, number, chart),
        "machine": machine(),
        "versions": versions(),
        "settings": asdict(request.settings),
        "reference": {
            "error": chart.reference.error,
            "flux_error": chart.reference.flux_error,
            "suns": chart.reference.suns,
            "seconds": chart.reference.seconds,
        },
        "rows": [asdict(row) for row in chart.rows],
        "needs": [asdict(need) for need in chart.needs],
        "notes": notes,
        "warnings": warnings,
    }
    picture, needs = draw(chart, title, _lines(request, scene, chart)), _needs(request, number, chart)
    folder = Path(request.out)
    paths = [folder / f"chart.{kind}" for kind in ("png", "csv", "json")]
    if needs:
        write_file(folder / "needs.png", needs)
    write_text(paths[1], table(chart.rows))
    write_json(paths[2], record)
    write_file(paths[0], picture)  # last: where it is, all is
    return paths


def _command(request, number, chart):
    """What makes this chart of the open file."""
    peers = " --peers" if any(row.peer for row in chart.rows) else ""
    return f"./dapple chart {_name()} --frame {number} --resolution {request.settings.resolution}{peers}"


def table(rows):
    """The rows as comma-separated values under the names of their columns; empty where there is no value."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        values = (getattr(row, name) for name in COLUMNS)
        writer.writerow([f"{v:.6g}" if isinstance(v, float) else "" if v is None else v for v in values])
    return text.getvalue()


def machine():
    """The processor's name."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def versions():
    """The versions of what the times depend on."""
    return {
        "Blender": bpy.app.version_string,
        "Python": platform.python_version(),
        "numpy": np.__version__,
        "embreex": _version("embreex"),
    }


def _version(package):
    """The version of an installed package, or that it is not there."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _needs(request, number, chart):
    """The bytes of needs.png, None where nothing was measured."""
    if not chart.needs:
        return None
    asked = request.settings.tolerance
    line = f"Orange: without it the light is worse than the tolerance, {asked:g}. Grey: it could be left out."
    return draw_needs(chart.needs, f"{_name()}, frame {number}: what the light of this scene needs", line, asked)


def _name():
    return Path(bpy.data.filepath).name or "unsaved scene"


def _lines(request, scene, chart):
    """What is said under the title: the scene, the reference, the machine."""
    side, truth = request.settings.resolution, chart.reference
    size = f"{len(scene.receivers)} map{'s' * (len(scene.receivers) > 1)} of {side} x {side} texels"
    water, casters = len(scene.water.triangles), sum(len(caster.triangles) for caster in scene.casters)
    kinds = [f"{n} triangles of {what}" for n, what in ((water, "water"), (casters, "glass and metal")) if n]
    size += f", {' and '.join(kinds)}. "
    suns = f", with 2 x {truth.suns} suns for the disc" if truth.suns else ""
    size += f"Reference: all light, twice{suns}."
    mine = ", ".join(f"{name} {version}" for name, version in versions().items())
    others = [f"{_OTHERS}{_SMOOTH if water else ''}."] if any(row.peer for row in chart.rows) else []
    return [size, f"{machine()}, one core; {mine}. {time.strftime('%Y-%m-%d')}", *others]
