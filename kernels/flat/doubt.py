"""How far still water is from the truth: by the waves, and along the borders of its light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scene import Sun
from .paths import Paths
from .ripples import Ripples

SAMPLES = 1 << 12  # texels at which the waves are looked up, about
_BOX = np.sqrt(3)  # side of the square with the variance of a disc of radius 1


def some(count):
    """A slice through `count` things that leaves about SAMPLES of them."""
    return slice(None, None, count // SAMPLES | 1)


@dataclass(frozen=True)
class Border:
    """Where light ends: steps, by how much its edges step, squared, in sum over all texels over their number; texel
    [m]: their width; above [m]: how far from the plane what shades is."""

    steps: float
    texel: float
    above: float = 0.0


@dataclass(frozen=True)
class Doubt:
    """What tells, for any waves about a Still plane, the mean squared error of its light: scale times the sum over
    texels with light e (n,) and Paths `ways`, inside a Border, and what `points` at the texels' centres leave."""

    light: object
    ways: Paths
    e: np.ndarray
    eta: float
    through: bool
    border: Border
    scale: float = 1.0
    points: float = 0.0

    def of(self, still):
        """The error under the water of a Still with this plane.

        Waves change what falls within the light, and move its edges. A lamp's disc makes them soft: w / 12 of a texel's
        squared light is lost along an edge that is to be w texels wide.
        """
        if not len(self.e):
            return self.points
        light, ways = self.light, self.ways
        away = 1.0 if isinstance(light, Sun) else max(float(np.mean(ways.away)), light.radius)
        radius = (light.angle / 2 if isinstance(light, Sun) else light.radius) / away
        penumbra = 2 * radius * float(ways.length.mean()) / (self.eta if self.through else 1)
        texel, border = self.border.texel, self.border
        ripples = Ripples(still, ways, self.eta, self.through, np.hypot(texel, _BOX / 2 * penumbra))
        squared, moved = ripples.squared(ways)
        edge = _shifted(np.sqrt(moved.mean() / 2) / texel) + (penumbra + 2 * radius * border.above) / texel / 12
        return self.points + self.scale * float((self.e**2 * squared).sum() + border.steps * len(self.e) * edge)


def _shifted(by):
    """Squared error, in squared light of a texel, for each texel along an edge that is off by so many texels."""
    return by * by * (1 - by / 3) if by < 1 else by - 1 / 3
