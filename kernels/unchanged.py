"""Whether two things are the same in every number."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np


def unchanged(one, other):
    """Whether two things are equal in every number: dataclasses, tuples, arrays, plain values."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        return all(unchanged(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(unchanged, one, other))
    return np.array_equal(one, other)
