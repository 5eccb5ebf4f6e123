"""What the planner says: a sentence for the artist, and numbers for the record."""

from __future__ import annotations

import numpy as np

from .choice import FLAT, MESH

_WHY = {
    FLAT: "the waves are low for this depth: still water in closed form, one path per texel",
    MESH: "the waves gather little light at this depth and their mesh is fine enough: every beam of the mesh as it is",
}
_LINES = "the waves gather the light into bright lines: every beam of the smooth water"
_SOFT = "the waves gather light, and more exactly than their mesh tells: every beam of the smooth water"
_OTHER = "the water is no gentle, smooth sheet, or not all: every beam, whatever it meets"
_CASTERS = "glass or metal casts light: every beam, whatever it meets"
_DROPPED = {
    "disc": "the sun's width is too small to show and left out",
    "dispersion": "colours part by too little to show and are not parted",
}
_BRIGHT = 1.3  # mean square over squared mean of light that has lines


def reason(plan, error):
    """A sentence on a Plan, and on the error (or None) that its solution was found to have."""
    choice = plan.choice
    parts = [_WHY.get(choice.kind) or _why_all(plan)]
    parts += [_DROPPED[term] for term in choice.without if term in _DROPPED]
    if not plan.measures.get("casters"):  # what glass costs hangs on how often its light is turned: counts do not tell
        parts.append(f"about {choice.seconds:.2g} s a frame")
    if error is not None:
        parts.append(f"expected error {100 * error:.2g} %")
    return ", ".join(parts)


def _why_all(plan):
    if plan.measures.get("casters"):
        return _CASTERS
    if not np.isfinite(plan.measures["mesh"]):
        return _OTHER
    return _LINES if plan.measures["power"] > _BRIGHT else _SOFT


def told(plan):
    """A Plan as numbers and names: what was left out, by which measures, and what each choice was predicted to be."""
    choices = {c.kind: {"error": _finite(c.error), "seconds": float(f"{c.seconds:.3g}")} for c in plan.choices}
    measures = {name: _finite(value) for name, value in plan.measures.items()}
    return {"choice": plan.choice.kind, "without": list(plan.choice.without), "measures": measures, "choices": choices}


def _finite(value):
    """A number to three digits, None where it is not finite."""
    return float(f"{value:.3g}") if np.isfinite(value) else None
