"""Parts of arrays, of which most are all: where every ray goes the same way nothing is copied.

What is one for all rays is one number, an array without axes, until they part.
"""

from __future__ import annotations

import numpy as np

ALL = slice(None)


def chosen(flags):
    """Where flags (k,) hold: ALL or indices."""
    count = np.count_nonzero(flags)
    return ALL if count == len(flags) else np.flatnonzero(flags)


def pick(array, at):
    """Columns `at`, ALL or indices (n,), of an array (...,k), or of one number for all."""
    return array if at is ALL or not array.ndim else array.take(at, -1, mode="clip")


def some(at):
    """Whether a part is not empty."""
    return at is ALL or len(at) > 0


def within(outer, inner):
    """The part `inner` of the part `outer`."""
    return inner if outer is ALL else pick(outer, inner)


def joined(one, other, counts):
    """Columns of two arrays, of counts (2,), or of one number for all of each, after each other."""
    if not one.ndim and not other.ndim and one == other:
        return one
    return np.concatenate([whole(part, n) for part, n in zip((one, other), counts, strict=True)], -1)


def whole(array, count):
    """An array of `count` columns, where it may be one number for all."""
    return array if array.ndim else np.full(count, array)


def indices(at, count):
    """The indices (n,) of a part of `count`."""
    return np.arange(count) if at is ALL else at
