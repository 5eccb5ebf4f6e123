"""What goes between a bake and its workers. Only plain data, so that nothing of Blender is needed to read it."""

from __future__ import annotations

from dataclasses import dataclass

from ...kernels.anchor import Anchor
from ...kernels.scene import Diagnostics, Scene, Settings


@dataclass(frozen=True)
class Job:
    """A frame to solve, by its number: a Scene, its Settings, and the Anchor of the animation, None where that is what
    is asked for; full: maps in float32; rough: whether pictures of it are wanted at once; sizes: of the receivers'
    maps, where these are not all of the settings' resolution."""

    number: int
    scene: Scene
    settings: Settings
    anchor: Anchor | None = None
    full: bool = False
    rough: bool = False
    sizes: tuple[int, ...] = ()


@dataclass(frozen=True)
class Stage:
    """What a worker is at, in a word or two."""

    text: str


@dataclass(frozen=True)
class Rough:
    """A rough picture: the files of its maps, one for each receiver."""

    files: tuple[bytes, ...]


@dataclass(frozen=True)
class Solved:
    """A frame: the files of its maps, one for each receiver; its Diagnostics; stage -> s of what is none of theirs."""

    files: tuple[bytes, ...]
    diagnostics: Diagnostics
    seconds: dict[str, float]


@dataclass(frozen=True)
class Failed:
    """A frame that cannot be solved: a sentence on why; details: a traceback where the fault is Dapple's, or empty."""

    sentence: str
    details: str = ""


@dataclass(frozen=True)
class Died:
    """A worker that ended in the midst of its job, with an exit code as `subprocess` gives it."""

    code: int
