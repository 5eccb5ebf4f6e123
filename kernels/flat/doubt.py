"""How far still water is from the truth: by the waves, and along the borders of its light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..scene import Sun
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


def doubt(still, light, ways, e, eta, through, border):
    """Mean squared error that still water leaves on texels with irradiance e (n,), of which Paths `ways` and the Border
    are known, times n.

    Waves change what falls within the light, and move its edges. A lamp's disc makes them soft: w / 12 of a texel's
    squared light is lost along an edge that is to be w texels wide.
    """
    if not len(e):
        return 0.0
    length = float(ways.length.mean())
    radius = light.angle / 2 if isinstance(light, Sun) else light.radius / max(float(np.mean(ways.away)), light.radius)
    penumbra, texel = 2 * radius * length / (eta if through else 1), border.texel
    ripples = Ripples(still, ways, eta, through, np.hypot(texel, _BOX / 2 * penumbra))
    squared, moved = ripples.squared(ways)
    edge = _shifted(np.sqrt(moved.mean() / 2) / texel) + (penumbra + 2 * radius * border.above) / texel / 12
    return float((e * e * squared).sum() + border.steps * len(e) * edge)


def _shifted(by):
    """Squared error, in squared light of a texel, for each texel along an edge that is off by so many texels."""
    return by * by * (1 - by / 3) if by < 1 else by - 1 / 3
