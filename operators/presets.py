"""The presets of quality that artists know by name: tolerances, relative mean squared errors."""

from __future__ import annotations

PRESETS = {"DRAFT": 5e-2, "PREVIEW": 1e-2, "FINAL": 1e-3}
CUSTOM = "CUSTOM"


def preset_of(tolerance: float) -> str:
    """The preset of a tolerance, kept in float32 or not; CUSTOM where it is none's."""
    near = (name for name, value in PRESETS.items() if abs(tolerance / value - 1) < 1e-5)
    return next(near, CUSTOM)
