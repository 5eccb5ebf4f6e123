"""How light reaches the water: from which side, over which distance, and how strong at each point of it.

A source tells of any points m (3,k), in the world: `towards` (3,k) or (3,1), unit, to the light; `distance` (k,) or
inf; and what they meet, as irradiance across the light over `power` (3,) [W/m^2], (k,) or 1. Of a lamp, `power` is the
irradiance at the distance `reach` from it.
"""

from __future__ import annotations

import numpy as np

from .scene import Piece, Spot

_TINY = np.finfo(float).tiny


class Parallel:
    """The light of a Sun: the same everywhere."""

    varies, reach = False, 1.0

    def __init__(self, sun):
        self.power = np.asarray(sun.irradiance, float)
        self._towards = -np.asarray(sun.direction, float)[:, None]

    def incident(self, m):
        """(towards, distance, met) at points m (3,k)."""
        return self._towards, np.inf, 1.0


class Central:
    """The light of a Point or a Spot, which spreads from it.

    A triangle of the water with area A, in a plane h from the lamp, takes the flux I A h / R^3 from round a point at
    distance R: A h / reach is the constant that `lit_water` keeps as its area, (reach / R)^3 what the point meets.
    """

    varies = True

    def __init__(self, lamp, reach):
        self.power = np.asarray(lamp.intensity, float) / reach**2
        self.position = lamp.position
        self.sharp = isinstance(lamp, Spot) and lamp.blend == 0  # what is met jumps to 0 on the cone's rim
        self._lamp, self.reach = lamp, reach

    def incident(self, m):
        """As `Parallel.incident`; 0 is met off a Spot's cone, and there only."""
        towards = self.position[:, None] - m
        distance = np.sqrt((towards * towards).sum(0))
        inverse = 1 / np.maximum(distance, _TINY)
        towards *= inverse
        met = (self.reach * inverse) ** 3
        return towards, distance, met * falloff(self._lamp, -towards) if isinstance(self._lamp, Spot) else met

    def growth(self, distance, beyond):
        """How much wider (k,) than sqrt(area) beams are across that came `distance` to still water and then as far
        as spreads them like `beyond`: tau / eta of refracted light, tau of reflected."""
        distance = np.maximum(distance, _TINY)
        return np.sqrt(self.reach / distance) * (1 + beyond / distance)


def falloff(spot, direction):
    """Share (k,) of a Spot's intensity along directions of travel (3,k): smoothstep over the blend, as Blender does.
    That of a Piece is the cosine, times what slats before it let pass: all that of a lamp without."""
    local = spot.frame @ direction
    cosine = local[2] / np.maximum(np.sqrt((local * local).sum(0)), _TINY)
    if isinstance(spot, Piece):
        return np.maximum(cosine, 0.0) * _between_slats(spot.half_angle, cosine)
    edge = np.cos(spot.half_angle)
    x = np.clip((cosine - edge) / max((1 - edge) * spot.blend, 1e-9), 0, 1)
    return x * x * (3 - 2 * x)


def _between_slats(half_angle, cosine):
    """What passes (k,) at a cosine to the axis, over the mean of all: a grid of slats hides all at tan half_angle, and
    on the way there as much as goes with the tangent. The flux is that without slats; after Cycles' spread."""
    if half_angle >= np.pi / 2:
        return 1.0
    edge = np.tan(half_angle)
    tangent = np.sqrt(np.maximum(1 - cosine * cosine, 0.0)) / np.maximum(cosine, _TINY)
    return np.maximum(edge - tangent, 0.0) / (edge - half_angle)


def in_cone(spot, soup):
    """Whether (T,) each triangle soup (T,3,3) may be in a Spot's cone: False is certain."""
    local = (soup - spot.position) @ spot.frame.T
    centre = local.mean(1)
    away = np.maximum(np.sqrt((centre * centre).sum(1)), _TINY)
    radius = np.sqrt(((local - centre[:, None]) ** 2).sum(2).max(1))
    off_axis = np.arccos(np.clip(centre[:, 2] / away, -1, 1))
    return off_axis <= spot.half_angle + np.arcsin(np.minimum(radius / away, 1)) + 1e-9
