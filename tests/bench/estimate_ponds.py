"""Ponds by chance, from still to stormy: what the planner's choices and its estimates are checked on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from waves import grid, shaded_smooth

from .accuracy_ponds import SOLAR, _covered, drawn

SEEDS = tuple(range(331, 361))
_RESOLUTIONS = (96, 128, 192, 256, 384)
_QUADS = (96, 128, 160)


def by_chance(seed):
    """(Pond, quads of its mesh, resolution of its map): a pond of `accuracy_ponds.drawn` with waves of a twelfth of
    their height to all of it, every second one under a sun 0.53 degrees wide."""
    rng = np.random.default_rng([seed, 5])
    pond = drawn(seed)
    height = np.exp(rng.uniform(np.log(0.08), 0.0))
    waves = replace(pond.waves, amplitude=pond.waves.amplitude * height)
    pond = replace(pond, waves=waves, angle=SOLAR if rng.random() < 0.5 else 0.0)
    return _covered(pond), int(rng.choice(_QUADS)), int(rng.choice(_RESOLUTIONS))


def water_of(pond, quads):
    """The Water of a Pond's waves on a regular grid, in float32 and with normals as Blender has them."""
    x, y, triangles = grid(quads, pond.side)
    x, y = x + pond.centre[0], y + pond.centre[1]
    positions = np.stack([x, y, pond.depth + pond.waves(x, y)[0]], 1).astype(np.float32)
    return shaded_smooth(positions.astype(float), triangles)
