"""What a person wants to know of the last bake, from its bake.json."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

FINE = ("lit", "dark")  # the texels that need no look


@dataclass(frozen=True)
class LastBake:
    """One frame of a bake: its number, method, why that one; seconds; watts on what bends light; shares of these that
    were received and lost, by cause; texels of a status other than fine; the estimated error, None where unknown."""

    frame: int
    method: str
    reason: str
    seconds: float
    watts: float
    received: float
    lost: dict[str, float] = field(default_factory=dict)
    odd: dict[str, int] = field(default_factory=dict)
    error: float | None = None


def last_bake(folder, frame) -> LastBake | None:
    """The LastBake of a frame in the bake.json of a folder, or of the frame baked next to it; None where there is no
    such file or it cannot be read."""
    path = Path(folder) / "bake.json"
    try:
        found = path.stat()
    except OSError:
        return None
    frames = _frames(str(path), found.st_mtime_ns, found.st_size)
    return frames[min(frames, key=lambda n: abs(n - frame))] if frames else None


@lru_cache(maxsize=1)  # a panel is drawn many times a second
def _frames(path, _time, _size):
    """{number: LastBake} of a bake.json as it was at a time."""
    try:
        known = json.loads(Path(path).read_text(encoding="utf-8"))
        return {int(n): _of(int(n), entry) for n, entry in known["frames"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _of(number, entry):
    watts = float(np.mean(entry["flux_in"]))
    received = sum(float(np.mean(flux)) for flux in entry["flux_received"].values())
    lost = {cause: float(np.mean(flux)) for cause, flux in entry["flux_lost"].items()}
    share = 1 / watts if watts > 0 else 0.0
    return LastBake(
        number,
        entry["method"],
        entry["reason"],
        sum(value for stage, value in entry["seconds"].items() if not stage.startswith("solve.")),
        watts,
        received * share,
        {cause: value * share for cause, value in lost.items() if value * share >= 5e-4},
        {status: count for status, count in entry["texels"].items() if status not in FINE},
        entry["estimated_error"],
    )
