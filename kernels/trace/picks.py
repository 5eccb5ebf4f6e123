"""Parts of arrays, of which most are all, or lie in a row: where rays that go the same way do, nothing is copied.

What is one for all rays is one number, an array without axes, until they part.
"""

from __future__ import annotations

import numpy as np

ALL = slice(None)


def chosen(flags):
    """Where flags (k,) hold: ALL, another slice, or indices."""
    count = np.count_nonzero(flags)
    if count == len(flags):
        return ALL
    first = int(flags.argmax())
    return slice(first, first + count) if flags[first : first + count].all() else np.flatnonzero(flags)


def pick(array, at):
    """Columns `at`, a slice or indices (n,), of an array (...,k), or of one number for all."""
    if at is ALL or not array.ndim:
        return array
    return array[..., at] if isinstance(at, slice) else array.take(at, -1, mode="clip")


def some(at):
    """Whether a part is not empty."""
    return at is ALL or (at.stop > at.start if isinstance(at, slice) else len(at) > 0)


def within(outer, inner, count):
    """The part `inner` of the part `outer` of `count`."""
    return inner if outer is ALL else outer if inner is ALL else pick(indices(outer, count), inner)


def joined(one, other, counts):
    """Columns of two arrays, of counts (2,), or of one number for all of each, after each other."""
    if not one.ndim and not other.ndim and one == other:
        return one
    return np.concatenate([whole(part, n) for part, n in zip((one, other), counts, strict=True)], -1)


def whole(array, count):
    """An array of `count` columns, where it may be one number for all."""
    return array if array.ndim else np.broadcast_to(array, count)


def indices(at, count):
    """The indices (n,) of a part of `count`."""
    return np.arange(count)[at] if isinstance(at, slice) else at
