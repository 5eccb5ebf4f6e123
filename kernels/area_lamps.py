"""Area lamps: flat light of some size, taken as points all over it, as many as its blur is wide.

[1] Shirley & Chiu 1997, A low distortion map between disk and square.
[2] Blender's *Spread*: a grid of slats before the lamp, of which those that hide it at an angle are counted.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .scene import Spot

_ALONG = 4  # points along each side, at most
_CLOSE = 1e-6  # of the way beyond: how near to what bends its light a lamp counts as, at least
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Patch(Spot):
    """A flat lamp without a size, or a part of one: intensity (3,) RGB [W/sr] along its axis, +z of its frame, and less
    as the cosine from there. half_angle below pi/2 is that of a grid before it, which takes no light but gathers it
    [2]; among: by how much more its light may err than that of a lamp that it is a part of, whose parts err apart, if
    not wholly."""

    half_angle: float = np.pi / 2
    blend: float = 1.0
    among: int = 1

    def falloff(self, cosine):
        """Intensity (k,) at cosines (k,) from the axis over that on it of a lamp without a grid."""
        facing = np.maximum(cosine, 0.0)
        if self.half_angle >= np.pi / 2:
            return facing
        slope = np.tan(self.half_angle)
        hidden = np.sqrt(np.maximum(1 - facing * facing, 0)) / np.maximum(facing, _TINY)
        return facing * np.maximum(slope - hidden, 0) / (slope - self.half_angle)


@dataclass(frozen=True)
class Area(Patch):
    """A flat lamp: sides (2,3) [m], from its centre to the middles of two sides that meet; round: the ellipse in
    these."""

    sides: np.ndarray = field(default_factory=lambda: np.zeros((2, 3)))
    round: bool = False

    def __post_init__(self):
        super().__post_init__()
        if np.shape(self.sides) != (2, 3):
            raise ValueError(f"sides must have shape (2, 3), got {np.shape(self.sides)}")


def in_patches(scene, texels):
    """(Scene with the Patches of its Area lamps in their place, sentences on what that leaves out), for Texels."""
    if not any(isinstance(light, Area) for light in scene.lights):
        return scene, []
    lights, sentences = [], []
    for light in scene.lights:
        if not isinstance(light, Area):
            lights.append(light)
            continue
        enough = _along(scene, light, texels)
        along = min(enough, _ALONG)
        lights += _patches(light, along)
        if along < enough:
            sentences.append(f"what is between {along**2} points all over the area lamp '{light.name}'")
    return replace(scene, lights=tuple(lights)), sentences


def _patches(lamp, along):
    """A Patch in the middle of each of `along` by `along` parts of an Area lamp; they spread as far as it does."""
    place = (np.stack(np.divmod(np.arange(along**2), along)) + 0.5) / along * 2 - 1
    if lamp.round:
        place = _on_disc(place)
    if along > 1:  # the middles of parts lie closer together than the parts
        place *= np.sqrt((1 / 4 if lamp.round else 1 / 3) / (place**2).mean(1, keepdims=True))
    points = lamp.position + place.T @ lamp.sides
    intensity = np.asarray(lamp.intensity, float) / along**2
    return [
        Patch(f"{lamp.name} {k}", point, intensity, 0.0, lamp.frame, lamp.half_angle, lamp.blend, along)
        for k, point in enumerate(points)
    ]


def _on_disc(place):
    """Points (2,n) of the square [-1, 1]^2 on the unit disc, equal areas to equal areas [1]."""
    x, y = place
    wide = np.abs(x) > np.abs(y)
    radius = np.where(wide, x, y)
    ratio = np.where(wide, y, x) / np.where(radius == 0, 1, radius)
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return radius * np.stack([np.cos(angle), np.sin(angle)])


def _along(scene, lamp, texels):
    """How many points along its sides an Area lamp needs for them to land a texel apart: those of light that goes
    straight on through the middle of what bends it to the nearest of the receivers."""
    texel = np.sqrt(min((t.area.sum() / len(t.area) for t in texels if len(t.area)), default=np.inf))
    widest = 0.0
    for mesh in (scene.water, *scene.casters):
        if not len(mesh.triangles):
            continue
        used = mesh.positions[np.unique(mesh.triangles)]
        middle, reach = used.mean(0), 0.0 if mesh is scene.water else np.ptp(used, axis=0).max() / 2
        beyond = reach + min(np.linalg.norm(t.positions - middle, axis=1).min() for t in texels if len(t.area))
        away = max(np.linalg.norm(lamp.position - middle) - reach, _CLOSE * beyond)
        widest = max(widest, 2 * np.linalg.norm(lamp.sides, axis=1).max() * beyond / away)
    return max(int(np.ceil(min(widest / texel, 1e6))), 1)
