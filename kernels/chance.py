"""Numbers as if by chance that depend on nothing but what they are for: the same in whatever order they are asked for.

[1] Steele, Lea & Flood 2014, Fast splittable pseudorandom number generators, OOPSLA.
"""

from __future__ import annotations

import numpy as np

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def uniform(seed, *parts):
    """Two numbers (2,...) from 0 to below 1 for each of parts, arrays (...) of integers or of floats, and a seed."""
    state = np.full((1,) * parts[-1].ndim, seed, np.uint64)
    for part in parts:
        bits = np.ascontiguousarray(part).view(np.uint64) if part.dtype == float else part.astype(np.uint64)
        state = _mixed(state * _GOLDEN ^ bits)
    return np.stack([_mixed(state + np.uint64(n)) >> np.uint64(11) for n in (1, 2)]) * 2.0**-53


def _mixed(number):
    """The finish of SplitMix64 [1], of numbers uint64."""
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        number = number ^ number >> np.uint64(shift)
        number *= np.uint64(factor)
    return number ^ number >> np.uint64(31)
