"""Which preset of quality a tolerance is."""

from __future__ import annotations

from ...kernels.presets import PRESETS

CUSTOM = "CUSTOM"


def preset_of(tolerance: float) -> str:
    """The preset of a tolerance, kept in float32 or not; CUSTOM where it is none's."""
    near = (name for name, value in PRESETS.items() if abs(tolerance / value - 1) < 1e-5)
    return next(near, CUSTOM)
