"""What a bake says while it is under way."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Preview:
    """A rough picture of a frame, whose maps lie in a folder as they will in that of the bake."""

    frame: int
    folder: Path


@dataclass(frozen=True)
class Progress:
    """A frame that is on disk: its number, how many of how many that makes, a sentence on it, its maps, and its
    warnings."""

    frame: int
    done: int
    total: int
    message: str
    maps: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Waiting:
    """Nothing is to be done now: how many of how many frames are on disk, what the workers are at, and about how many
    seconds are left, None where that is not known yet."""

    done: int
    total: int
    message: str
    left: float | None = None


def clock(seconds):
    """Seconds as people read them: 8 s, 1:05 min, 2:03 h."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d} h"
