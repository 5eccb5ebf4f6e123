"""What the planner chooses: a method and the terms that it leaves out; and the plan of a frame."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from .glance import Glance

FLAT, MESH, SMOOTH = "flat", "mesh", "smooth"
# Of the tolerance, what a prediction may be: the truth is up to as much more, see docs/planner.md.
_MARGINS = {FLAT: 0.85, MESH: 0.5, SMOOTH: 1.0}


@dataclass(frozen=True)
class Choice:
    """What to solve by: kind, of FLAT, MESH and SMOOTH; method; terms without; error, of what is left out, over the
    mean square of the light, and seconds, both as predicted."""

    kind: str
    method: str
    without: tuple[str, ...]
    error: float
    seconds: float

    def fits(self, tolerance):
        """Whether it is predicted to meet the tolerance."""
        return self.error <= _MARGINS[self.kind] * tolerance


@dataclass(frozen=True)
class Plan:
    """The Choice of a frame, all that there were, the measures that told: name -> number, and the Glance at it."""

    choice: Choice
    choices: tuple[Choice, ...]
    measures: dict[str, float] = field(default_factory=dict)
    glance: Glance | None = None

    @property
    def of_one(self):
        """Whether there was no other choice to be weighed."""
        return len(self.choices) == 1

    def settings(self, settings):
        """The Settings by which to solve what `settings` ask for."""
        without = (*settings.without, *self.choice.without)
        return replace(settings, method=self.choice.method, without=tuple(dict.fromkeys(without)))
