"""What a method will cost, told from counts: CPU seconds of one core.

The constants are microseconds for each triangle and each texel, fitted by `tests/bench/bench_costs.py`; choices hang on
their ratios only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# microseconds: to begin with, for a triangle, for a texel
FLAT = 2590.0, 0.0523, 0.00221  # in an animation whose receivers lie still
BEAMS = 205.0, 0.822, 0.161
BEAMS_BY_RAYS = 77600.0, 0.734, 0.838
SURFACE = 16300.0, 2.05, 0.205  # the spline, and the water of one part a triangle
PARTS = 0.0, 1.2, 0.0  # of a triangle; set by hand
DISC = 0.0, 0.0291, 0.233


@dataclass(frozen=True)
class Counts:
    """Of one frame: triangles of the water, texels, lights (solves, for dispersion), and whether light needs rays to be
    followed."""

    triangles: int
    texels: int
    lights: int
    rays: bool


def flat(counts):
    """Seconds of still water."""
    return _seconds(FLAT, counts)


def beams(counts, parts=None, disc=False):
    """Seconds of beams; parts: k, of the smooth water's k x k parts of a triangle, None for the mesh as it is."""
    cut = (parts or 1) ** 2
    each = BEAMS_BY_RAYS if counts.rays else BEAMS
    seconds = _seconds(each, counts, cut)
    if parts is not None:
        seconds += _seconds(SURFACE, counts) / counts.lights + (_seconds(PARTS, counts, cut) if parts > 1 else 0.0)
    return seconds + (_seconds(DISC, counts, cut) if disc else 0.0)


def _seconds(each, counts, cut=1):
    return 1e-6 * counts.lights * float(np.dot(each, (1, counts.triangles * cut, counts.texels)))
