"""bake.json: what each frame is made of and how it was come by."""

from __future__ import annotations

import json
import textwrap
from dataclasses import asdict

import bpy
import numpy as np

from ..errors import DappleError
from ..maps.write import disk_sentence, plain, write_text
from ..read.digest import checksum
from .turns import turn

VERSION = 1


class Record:
    """The record of one folder: the frames of earlier bakes, of others that go on there, and those that this one
    adds."""

    def __init__(self, path, head):
        self._path, self._head = path, head
        self._frames, self._texts, self._seen = {}, {}, None

    @classmethod
    def open(cls, request):
        """The record in the request's folder, without a change on disk; raises DappleError where it is not ours."""
        head = {
            "version": VERSION,
            "blender": bpy.app.version_string,
            "settings": asdict(request.settings),
            "water": list(request.water),
            "receivers": list(request.receivers),
            "volume": asdict(request.volume) if request.volume else None,
            "depth": "full" if request.full else "half",
            "texels_per_metre": request.density,
        }
        record = cls(request.out / "bake.json", head)
        record._read()
        return record

    def entry(self, number):
        """What is known of a frame, None where it is none."""
        return self._frames.get(number)

    def known(self, number, inputs):
        """The entry of a frame that was baked from the same inputs, by their digest, and whose maps are on disk to the
        last bit; else None."""
        entry = self._frames.get(number)
        if entry is None or entry.get("inputs") != inputs or entry["files"].keys() != entry["checksums"].keys():
            return None
        whole = all(_sum(self._path.parent / file) == entry["checksums"][name] for name, file in entry["files"].items())
        return entry if whole else None

    def add(self, number, entry):
        """Put the entry of a frame in the place of any earlier one, and the whole record on disk, with what other bakes
        have added since. Raises DappleError where the disk does not take it."""
        try:
            with turn(self._path):
                self._read()
                self._frames[number] = plain({"settings": self._head["settings"], **entry})
                self._texts[number] = _indented(self._frames[number])
                write_text(self._path, self._text())
                self._seen = _stamp(self._path)
        except OSError as error:
            raise DappleError(disk_sentence(self._path, error)) from error

    def _read(self):
        """Take in what is on disk, if that is not what it was."""
        stamp = _stamp(self._path)
        if stamp is None or stamp != self._seen:
            self._frames = _earlier_frames(self._path)
            self._texts = {number: _indented(entry) for number, entry in self._frames.items()}
            self._seen = stamp

    def _text(self):
        """The record as JSON. Each frame is put into words once: a long animation would be all words."""
        head = json.dumps(plain(self._head), indent=1, allow_nan=False).removesuffix("\n}")
        frames = ",\n".join(f'  "{number}": {self._texts[number]}' for number in sorted(self._texts))
        return head + ',\n "frames": {\n' + frames + "\n }\n}\n"


def frame_entry(scene, diagnostics, seconds, warnings):
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
    return {**entry, **medium, "lights": lights, "casters": casters, "warnings": warnings}


def summary(number, entry):
    """One sentence on a frame's entry: method, seconds, energy."""
    seconds = sum(value for stage, value in entry["seconds"].items() if not stage.startswith("solve."))
    inward = float(np.mean(entry["flux_in"]))
    text = f"Frame {number}: {entry['method']}, {seconds:.2f} s"
    if not inward > 0:
        return f"{text}; no light meets what bends it."
    received = sum(np.mean(flux) for flux in entry["flux_received"].values())
    lost = sum(np.mean(flux) for flux in entry["flux_lost"].values())
    text += f"; of {inward:.4g} W on what bends it {received / inward:.1%} received, {lost / inward:.1%} lost."
    return f"{text} {entry['reason'].capitalize()}." if entry["plan"] else text


def _indented(entry):
    return textwrap.indent(json.dumps(entry, indent=1, allow_nan=False), "  ").lstrip()


def _stamp(path):
    """What changes with a file; None where there is none."""
    try:
        known = path.stat()
    except OSError:
        return None
    return known.st_ino, known.st_size, known.st_mtime_ns


def _sum(path):
    """The checksum of a file, None where it cannot be read."""
    try:
        return checksum(path.read_bytes())
    except OSError:
        return None


def _earlier_frames(path):
    """Entries by frame number of the bake.json at `path`; none where there is no such file."""
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        if known["version"] == VERSION:
            return {int(number): dict(entry) for number, entry in known["frames"].items()}
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise DappleError(f"{path} cannot be read ({error}); move it away or choose another folder.") from error
    raise DappleError(f"{path} is of version {known['version']}, not {VERSION}; move it away or choose another folder.")


def recorded_frames(folder):
    """{number: entry} of what is baked in a folder; raises DappleError where its bake.json is not ours."""
    return _earlier_frames(folder / "bake.json")


def note_export(folder, form, receiver, said):
    """Write into the bake.json of a folder what an export made of its maps. A later bake takes it out, since what was
    exported then is no longer what is baked. Raises DappleError where the disk does not take it."""
    path = folder / "bake.json"
    try:
        with turn(path):
            known = json.loads(path.read_text(encoding="utf-8"))
            known.setdefault("exports", {}).setdefault(form, {})[receiver] = plain(said)
            write_text(path, json.dumps(known, indent=1, allow_nan=False) + "\n")
    except OSError as error:
        raise DappleError(disk_sentence(path, error)) from error
