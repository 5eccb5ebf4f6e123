"""Measures of a scene that stay as they are while things in it move a little, so that rays recur bit for bit."""

from __future__ import annotations

import numpy as np

_STEPS = 8  # of the size: how coarse bounds are
_FINE = 4  # sizes to an octave
_ROUNDING = 1e-9  # of a size: what is so near to one is that


def step(low, high):
    """A power of two [m], about an eighth of how far it is from low to high (3,); 1 for nothing."""
    size = (high - low).max()
    return 2.0 ** np.ceil(np.log2(size)) / _STEPS if size > 0 else 1.0


def bounds(low, high):
    """Low and high (3,), outward to whole steps."""
    own = step(low, high)
    return np.floor(low / own) * own, np.ceil(high / own) * own


def no_larger(size, unit):
    """A size, or up to a sixth less: one of steps from a unit on."""
    return unit * 2.0 ** (np.floor(_FINE * np.log2(size / unit) + _ROUNDING) / _FINE)
