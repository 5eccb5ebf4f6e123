"""Lamps of the evaluated scene as lights of `kernels.scene`.

What a lamp of some power means is as Blender shows it on a white diffuse plane, measured in Cycles 5.0: a point or
spot lamp of P watts has the radiant intensity P / (4 pi), a spot on its axis, whatever its cone; an area lamp sends out
its P watts, whatever its size and spread, and without a spread has P / pi along its axis.
"""

from __future__ import annotations

import math

import numpy as np

from ...kernels.scene import Area, Point, Spot, Sun
from ...kernels.under_water import under_water
from ..errors import DappleError

_ROUND, _OBLONG = ("DISK", "ELLIPSE"), ("RECTANGLE", "ELLIPSE")
_NARROWEST = math.radians(0.1)  # of an area lamp's spread: what is narrower looks the same


def read_lights(lamps, water):
    """(lights, warnings) of (name, light, world matrix (4,4)) tuples of the lamps that render, over a Water, if any.

    Left out with a warning: suns that shine upward, lamps that stand under the water, area lamps without an area.
    Raises DappleError where no lamp is left that shines.
    """
    lights, warnings = [], []
    for name, light, matrix in lamps:
        if light.type == "AREA" and not _surface(light, matrix) > 0:
            warnings.append(f"Lamp '{name}' has no area and was left out: set its size and its scale to more than 0.")
            continue
        found = _READERS[light.type](name, light, matrix)
        power = found.irradiance if light.type == "SUN" else found.intensity
        if not (power >= 0).all() or not np.isfinite(power).all():
            warnings.append(f"Lamp '{name}' was left out: its power is negative or no number; set it to more than 0.")
            continue
        if not power.any():
            continue
        wrong = _wrong(found, water)
        if wrong:
            warnings.append(wrong)
        else:
            lights.append(found)
    if not lights:
        why = " ".join(warnings) or "Add one (Add > Light > Sun)."
        raise DappleError(f"The scene has no lamp that renders and shines on what bends light. {why}")
    return tuple(lights), warnings


def _wrong(light, water):
    """Why a light cannot be baked, as a sentence; empty if it can."""
    if not len(water.triangles):
        return ""
    if isinstance(light, Sun):
        upward = light.direction[2] >= 0
        return f"Sun '{light.name}' shines upward and was left out: rotate it so that it shines down." if upward else ""
    if all(under_water(water, place) for place in _places(light)):
        return (
            f"Lamp '{light.name}' is under the water and was left out: move it above, for light that the water bends."
        )
    return ""


def _places(light):
    """Points (n,3) of a lamp: of an area lamp its ends too, part of which may be above the water."""
    ends = [light.half_axes, -light.half_axes] if isinstance(light, Area) else []
    return np.concatenate([light.position[None], *(light.position + end for end in ends)])


def _sun(name, light, matrix):
    """The Sun of a Blender light: strength 1 and white is 1 W/m^2 across its rays."""
    irradiance = _colour(light)
    if not getattr(light, "normalize", True):
        irradiance *= _disc_area(light.angle)
    return Sun(name, _axis(matrix), irradiance, float(light.angle))


def _disc_area(angle):
    """Projected solid angle [sr] of the lamp's disc: with `normalize` off the strength is radiance, not irradiance."""
    return math.pi * math.sin(angle / 2) ** 2 if angle > 0 else 1.0


def _point(name, light, matrix):
    return Point(name, matrix[:3, 3], _intensity(light), float(light.shadow_soft_size))


def _spot(name, light, matrix):
    """The Spot of a Blender light, whose cone is stretched by the object's scale."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    axes = matrix[:3, :3] / lengths
    frame = np.stack([axes[:, 0] / lengths[0], axes[:, 1] / lengths[1], -axes[:, 2] / lengths[2]])
    half_angle, blend = min(light.spot_size / 2, math.pi / 2), float(light.spot_blend)
    radius = float(light.shadow_soft_size)
    return Spot(name, matrix[:3, 3], _intensity(light), radius, frame, half_angle, blend)


def _area(name, light, matrix):
    """The Area of a Blender light, which shines along its own -z."""
    half_axes = _half_axes(light, matrix)
    if np.cross(*half_axes) @ matrix[:3, 2] > 0:
        half_axes[1] *= -1
    intensity = _colour(light) / math.pi
    if not getattr(light, "normalize", True):
        intensity *= _surface(light, matrix)
    spread = float(np.clip(light.spread, _NARROWEST, math.pi))
    return Area(name, matrix[:3, 3], intensity, 0.0, half_axes, light.shape in _ROUND, spread)


def _half_axes(light, matrix):
    """Half axes (2,3) [m] of an area lamp: of squares and discs one size counts for both."""
    sizes = np.array([light.size, light.size_y if light.shape in _OBLONG else light.size])
    return matrix[:3, :2].T * sizes[:, None] / 2


def _surface(light, matrix):
    """The area [m^2] of an area lamp."""
    across = np.linalg.norm(np.cross(*_half_axes(light, matrix)))
    return float(across * (math.pi if light.shape in _ROUND else 4))


_READERS = {"SUN": _sun, "POINT": _point, "SPOT": _spot, "AREA": _area}


def _axis(matrix):
    """Unit direction (3,) in which a sun or spot shines."""
    return -matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])


def _intensity(light):
    """Radiant intensity (3,) [W/sr] of a point or spot lamp; with `normalize` off its power is per area of its sphere,
    and counts four times where that has none."""
    intensity = _colour(light) / (4 * math.pi)
    if not getattr(light, "normalize", True):
        intensity *= 4 * math.pi * light.shadow_soft_size**2 if light.shadow_soft_size > 0 else 4.0
    return intensity


def _colour(light):
    """Power or strength of a light (3,) in red, green and blue."""
    colour = light.energy * np.array(light.color, dtype=np.float64)
    colour *= 2.0 ** getattr(light, "exposure", 0.0)  # lamps have these three since Blender 4.5
    if getattr(light, "use_temperature", False):
        colour *= np.array(light.temperature_color, dtype=np.float64)
    return colour
