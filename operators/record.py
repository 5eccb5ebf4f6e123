"""bake.json: what each frame is made of and how it was come by."""

from __future__ import annotations

import json
from dataclasses import asdict

import bpy
import numpy as np

from .errors import DappleError
from .write import write_json

VERSION = 1


class Record:
    """The record of one folder: the frames of earlier bakes, and those that this bake adds."""

    def __init__(self, path, head, frames):
        self._path, self._head, self._frames = path, head, frames

    @classmethod
    def open(cls, request):
        """The record in the request's folder, without a change on disk; raises DappleError where it is not ours."""
        path = request.out / "bake.json"
        head = {
            "version": VERSION,
            "blender": bpy.app.version_string,
            "settings": asdict(request.settings),
            "water": list(request.water),
            "receivers": list(request.receivers),
            "volume": asdict(request.volume) if request.volume else None,
            "depth": "full" if request.full else "half",
        }
        return cls(path, head, _earlier_frames(path))

    def add(self, number, entry):
        """Put the entry of a frame in the place of any earlier one, and the whole record on disk."""
        self._frames[number] = {"settings": self._head["settings"], **entry}
        frames = {str(n): self._frames[n] for n in sorted(self._frames)}
        write_json(self._path, {**self._head, "frames": frames})


def frame_entry(scene, diagnostics, seconds, files, warnings):
    """What bake.json says of a frame; seconds are those of the operators' stages, and the solver's as solve.stage."""
    entry = asdict(diagnostics)
    entry["seconds"] = {
        **{stage: seconds[stage] for stage in ("extract", "texels", "solve")},
        **{f"solve.{stage}": value for stage, value in diagnostics.seconds.items()},
        "write": seconds["write"],
    }
    lights = [{"type": type(light).__name__.lower(), **asdict(light)} for light in scene.lights]
    medium = {"eta": scene.eta, "sigma_a": scene.sigma_a}
    casters = [{"name": c.name, type(c.material).__name__.lower(): asdict(c.material)} for c in scene.casters]
    return {**entry, **medium, "lights": lights, "casters": casters, "files": files, "warnings": warnings}


def summary(number, entry):
    """One sentence on a frame's entry: method, seconds, energy."""
    seconds = sum(value for stage, value in entry["seconds"].items() if not stage.startswith("solve."))
    inward = float(np.mean(entry["flux_in"]))
    text = f"Frame {number}: {entry['method']}, {seconds:.2f} s"
    if not inward > 0:
        return f"{text}; no light meets what bends it."
    received = sum(np.mean(flux) for flux in entry["flux_received"].values())
    lost = sum(np.mean(flux) for flux in entry["flux_lost"].values())
    return f"{text}; of {inward:.4g} W on what bends it {received / inward:.1%} received, {lost / inward:.1%} lost."


def _earlier_frames(path):
    """Entries by frame number of the bake.json at `path`; none where there is no such file."""
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        if known["version"] == VERSION:
            return {int(number): entry for number, entry in known["frames"].items()}
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise DappleError(f"{path} cannot be read ({error}); move it away or choose another folder.") from error
    raise DappleError(f"{path} is of version {known['version']}, not {VERSION}; move it away or choose another folder.")
