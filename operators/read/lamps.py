"""Lamps of the evaluated scene as lights of `kernels.scene`.

What a lamp of some power means is as Blender shows it on a white diffuse plane, measured in Cycles 5.0: a point or
spot lamp of P watts has the radiant intensity P / (4 pi), a spot on its axis, whatever its cone; an area lamp P / pi
along its axis.
"""

from __future__ import annotations

import math

import numpy as np

from ...kernels.area_lamps import Area
from ...kernels.optics import sun_frame
from ...kernels.scene import Point, Spot, Sun
from ...kernels.under_water import under_water
from ..errors import DappleError


def read_lights(lamps, water):
    """(lights, warnings) of (name, light, world matrix (4,4)) tuples of the lamps that render, over a Water, if any.

    Left out with a warning: suns that shine upward, lamps that stand under the water. Raises DappleError where no lamp
    is left that shines.
    """
    lights, warnings = [], []
    for name, light, matrix in lamps:
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
    if under_water(water, light.position):
        return (
            f"Lamp '{light.name}' is under the water and was left out: move it above, for light that the water bends."
        )
    return ""


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
    """The Area of a Blender light, in its own x and y."""
    round_one = light.shape in ("DISK", "ELLIPSE")
    sizes = light.size, light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    sides = matrix[:3, :2].T * np.array(sizes)[:, None] / 2
    intensity = _colour(light) / math.pi
    if not getattr(light, "normalize", True):
        intensity *= (math.pi if round_one else 4) * np.linalg.norm(np.cross(*sides))
    frame = sun_frame(_axis(matrix)) * [[1.0], [1.0], [-1.0]]
    half_angle = min(float(light.spread) / 2, math.pi / 2)
    return Area(name, matrix[:3, 3], intensity, 0.0, frame, half_angle, sides=sides, round=round_one)


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
