"""Sun lamps of the evaluated scene as `kernels.scene.Sun`."""

from __future__ import annotations

import math

import numpy as np

from ..kernels.scene import Sun
from .errors import DappleError


def read_suns(lamps):
    """(suns, warnings) of (name, light, world matrix (4,4)) tuples of the lamps that render.

    Raises DappleError where no Sun lamp shines down on the scene.
    """
    suns, upward, warnings = [], [], []
    for name, light, matrix in lamps:
        if light.type != "SUN":
            kind = light.type.lower()
            warnings.append(f"Lamp '{name}' is a {kind} lamp and was left out: this version bakes Sun lamps only.")
            continue
        sun = _sun(name, light, matrix)
        if not sun.irradiance.any():
            continue
        (suns if sun.direction[2] < 0 else upward).append(sun)
    warnings += [f"Sun '{sun.name}' shines upward and was left out: it is below the horizon." for sun in upward]
    if not suns:
        raise DappleError(_no_sun(upward, warnings))
    return tuple(suns), warnings


def _no_sun(upward, warnings):
    """What to tell the user where nothing shines."""
    if upward:
        names = ", ".join(f"'{sun.name}'" for sun in upward)
        return f"Sun {names} shines upward, from below the horizon; rotate it so that its light travels down."
    others = f" {' '.join(warnings)}" if warnings else ""
    return f"The scene has no Sun lamp that renders and shines; add one (Add > Light > Sun).{others}"


def _sun(name, light, matrix):
    """The Sun of a Blender light: strength 1 and white is 1 W/m^2 across its rays."""
    irradiance = light.energy * np.array(light.color, dtype=np.float64)
    irradiance *= 2.0 ** getattr(light, "exposure", 0.0)  # lamps have these three since Blender 4.5
    if getattr(light, "use_temperature", False):
        irradiance *= np.array(light.temperature_color, dtype=np.float64)
    if not getattr(light, "normalize", True):
        irradiance *= _disc_area(light.angle)
    direction = -matrix[:3, 2]
    return Sun(name, direction / np.linalg.norm(direction), irradiance, float(light.angle))


def _disc_area(angle):
    """Projected solid angle [sr] of the lamp's disc: with `normalize` off the strength is radiance, not irradiance."""
    return math.pi * math.sin(angle / 2) ** 2 if angle > 0 else 1.0
