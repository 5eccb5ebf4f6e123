"""Where bent rays meet the receivers, estimated by look-ups in the positions texture instead of by intersection [1].

A point at the distance x on the ray, v + x r, is looked up; the point that the texture holds there is at some distance
from v, and that is the next x. On a plane with normal n, under light along l, the error of x changes by the factor

    1 - (r.l) (r.n) / (l.n)

from look-up to look-up: 0.05 for a sun at 45 degrees and a receiver that faces it, -0.17 for a level floor, less than
-1 from 73 degrees on, where it diverges. Newton's method on the distance from v + x r to the point that is looked up
there takes twice the look-ups, and one step on a plane that a sun shines on.

[1] Shah, Konttinen & Pattanaik 2007, Caustics Mapping: III.C, III.D and the appendix. Theirs starts at x = 1, in the
units of its scene.
"""

from __future__ import annotations

import numpy as np

_STEP = 1e-3  # of the distance, over which Newton's slope is taken: over more, it is wrong next to the root
_TINY = np.finfo(float).tiny


def estimate(positions, v, r, iterations, x):
    """Points (3,n) where rays from v (3,n) along r (3,n) land, and triangles (n,), by [1]'s iteration from x (n,)."""
    for _ in range(iterations):
        seen, _ = positions.look_up(v + x * r)
        x = _kept(_length(seen - v), x)
    return positions.look_up(v + x * r)


def newton(positions, v, r, iterations, x):
    """As `estimate`, by the appendix's method of Newton and Raphson."""

    def off(x):
        p = v + x * r
        return _length(positions.look_up(p)[0] - p)

    for _ in range(iterations):
        here, step = off(x), _STEP * x
        slope = (off(x + step) - here) / np.maximum(step, _TINY)
        x = np.maximum(_kept(x - here / np.where(slope == 0, np.inf, slope), x), 0.0)
    return positions.look_up(v + x * r)


def start(positions, v):
    """Distances (n,) from points v (3,n) to what lies straight behind them; their mean where that is nothing."""
    straight = _length(positions.look_up(v)[0] - v)
    known = straight[np.isfinite(straight)]
    return np.where(np.isfinite(straight), straight, known.mean() if len(known) else 1.0)


def _kept(new, old):
    """New values, where they are numbers."""
    return np.where(np.isfinite(new), new, old)


def _length(vectors):
    return np.sqrt((vectors * vectors).sum(0))
