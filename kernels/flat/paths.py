"""The one path through still water, or off it, from a light to each point: Snell's law, in closed form or by Newton.

Coordinates are those in the plane of the water, which is z = 0; light comes from z > 0 after a change of sides. Of a
lamp at height H over the plane the light that lands r away from below it, h deep, enters x away with

    sin i = eta sin t,   x = H tan i,   r - x = h tan t,

and spreads, per solid angle of the lamp, to r (dr / di) / sin i on a level receiver.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..optics import cosine_refracted, fresnel_transmittance
from ..scene import Spot, Sun
from ..sources import falloff

_STEPS = 40  # at most; Newton's take 4 to 8
_TINY = np.finfo(float).tiny


@dataclass
class Paths:
    """Paths (n,) to points: enters (2,n), where they meet the plane; arrives (3,n), unit, how they run from there on;
    length (n,) [m] of that; towards (3,n) or (3,1), unit, from there to the light, and away (n,) or inf, how far that
    is; strength (n,), what falls across them per irradiance of the sun or intensity of the lamp, without absorption;
    spread (n,), by how much a beam is wider there than at the plane."""

    enters: np.ndarray
    arrives: np.ndarray
    length: np.ndarray
    towards: np.ndarray
    away: np.ndarray
    strength: np.ndarray
    spread: np.ndarray

    def take(self, index):
        """The Paths with these indices."""
        return Paths(*(_taken(value, index) for value in vars(self).values()))


def _taken(value, index):
    """What belongs to some paths of (k,n) or (n,); what all share stays."""
    return value if np.isscalar(value) or value.shape[-1] == 1 else value[..., index]


def paths(still, light, p, eta, through):
    """Paths of a light to points p (3,n) in the plane of Still, all below it where they go `through` and above it where
    they are mirrored; None for a light that is not above it."""
    if isinstance(light, Sun):
        return _of_sun(still.frame @ np.asarray(light.direction, float), p, eta, through)
    return _of_lamp(still, light, p, eta, through)


def _of_sun(d, p, eta, through):
    cos_i = -d[2]
    if cos_i <= 0:
        return None
    cos_t = cosine_refracted(cos_i, eta)
    passed = fresnel_transmittance(cos_i, cos_t, eta)
    if through:
        arrives, strength = np.array([d[0] / eta, d[1] / eta, -cos_t]), passed * cos_i / cos_t
    else:
        arrives, strength = np.array([d[0], d[1], cos_i]), 1 - passed
    length = p[2] / arrives[2]
    ones = np.ones(p.shape[1])
    enters = p[:2] - length * arrives[:2, None]
    return Paths(enters, arrives[:, None], length, -d[:, None], np.inf, strength * ones, ones)


def _of_lamp(still, lamp, p, eta, through):
    place = still.to_plane(lamp.position[None])[:, 0]
    height, deep = place[2], np.abs(p[2])
    if height <= 0:
        return None
    out = p[:2] - place[:2, None]
    r = np.sqrt((out * out).sum(0))
    out = out / np.maximum(r, _TINY)
    x = entry(r, height, deep, eta) if through else r * height / (height + deep)
    enters = place[:2, None] + x * out
    away = np.sqrt(x * x + height**2)
    sin_i, cos_i = x / away, height / away
    cos_t = cosine_refracted(cos_i, eta)
    passed = fresnel_transmittance(cos_i, cos_t, eta)
    going = np.concatenate([out * sin_i, -cos_i[None]])
    if through:
        arrives = np.concatenate([out * sin_i / eta, -cos_t[None]])
        across, along = away + deep / (eta * cos_t), away / cos_i + deep * cos_i / (eta * cos_t**3)
        strength = passed / (across * along * cos_t)
    else:
        arrives = going * [[1.0], [1.0], [-1.0]]
        across = away + deep / cos_i
        strength = (1 - passed) / across**2
    if isinstance(lamp, Spot):
        strength = strength * falloff(lamp, still.frame.T @ going)
    cosine = cos_t if through else cos_i
    return Paths(enters, arrives, deep / cosine, -going, away, strength, across / away)


def entry(r, height, deep, eta):
    """x (n,) where light enters that comes from `height` over the plane and lands r (n,) away from below there, deep
    (n,), by Newton's method kept inside brackets: f grows from f(0) <= 0 to f(r) >= 0."""
    low, high = np.zeros(len(r)), r.copy()
    x = r * height / (height + deep / eta)
    x = np.where(deep > 0, x, r)
    rest = np.flatnonzero(deep > 0)
    for _ in range(_STEPS):
        at, span, h = x[rest], r[rest], deep[rest]
        one, other = np.hypot(at, height), np.hypot(span - at, h)
        other = np.maximum(other, _TINY)
        f = at / one - eta * (span - at) / other
        slope = height**2 / one**3 + eta * h**2 / other**3
        low[rest], high[rest] = np.where(f < 0, at, low[rest]), np.where(f > 0, at, high[rest])
        step = at - f / np.maximum(slope, _TINY)
        within = (step > low[rest]) & (step < high[rest])
        x[rest] = np.where(f == 0, at, np.where(within, step, (low[rest] + high[rest]) / 2))
        rest = rest[np.abs(x[rest] - at) > 1e-13 * span]
        if not len(rest):
            break
    return x
