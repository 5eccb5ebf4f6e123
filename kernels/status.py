"""What became of a texel: one code for every method, so that a dark texel says why it is dark."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Status(IntEnum):
    EMPTY = 0  # no receiver here
    LIT = 1  # light from the water arrives
    DARK = 2  # no light arrives
    NO_WATER = 3  # walk: the straight ray to the sun does not pass the water
    OFF_THE_RIM = 4  # walk: the curve left the water's mesh before a root
    NO_ROOT = 5  # walk: the curve closed on itself without a root
    BLOCKED = 6  # walk: the path was found and an object stands in it
    TORN = 7  # walk: the curve is torn where the normals jump (flat or custom shading)
    LOST = 8  # walk: more steps than the mesh can justify, or a point on a fold, which has no finite light
    INCOMPLETE = 9  # walk: the signed count of its paths proves that one was missed or counted twice


def counts(codes):
    """Texels per status, as {name: count}, EMPTY left out."""
    tally = np.bincount(codes.ravel(), minlength=len(Status))
    return {status.name.lower(): int(tally[status]) for status in Status if status and tally[status]}
