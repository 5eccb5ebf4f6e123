"""Parts of arrays, of which most are all: where every ray goes the same way nothing is copied."""

from __future__ import annotations

import numpy as np

ALL = slice(None)


def chosen(flags):
    """Where flags (k,) hold: ALL or indices."""
    count = np.count_nonzero(flags)
    return ALL if count == len(flags) else np.flatnonzero(flags)


def pick(array, at):
    """Columns `at`, ALL or indices (n,), of an array (...,k)."""
    return array if at is ALL else array.take(at, -1, mode="clip")


def some(at):
    """Whether a part is not empty."""
    return at is ALL or len(at) > 0


def within(outer, inner):
    """The part `inner` of the part `outer`."""
    return inner if outer is ALL else pick(outer, inner)


def indices(at, count):
    """The indices (n,) of a part of `count`."""
    return np.arange(count) if at is ALL else at
