"""What is worth its time: the runs that no other beats in both error and time."""

from __future__ import annotations

import numpy as np


def front(seconds, errors):
    """Whether no other run is as quick and as good, and better in one of the two: (n,) bool, for seconds and errors
    (n,). Of equal runs the first counts. Errors that are not finite are on no front.

    Raises ValueError for shapes that differ.
    """
    seconds, errors = _checked(seconds, errors)
    best, on = np.inf, np.zeros(len(seconds), bool)
    for k in np.lexsort((np.arange(len(seconds)), errors, seconds)):
        if errors[k] < best:
            best, on[k] = errors[k], True
    return on


def over_front(own_seconds, own_error, seconds, errors):
    """How many times as long a run takes as the quickest of others that is at least as good; 0 where none is as good.

    own_seconds, own_error: of the run; seconds, errors (n,): of the others. Raises ValueError for shapes that differ.
    """
    seconds, errors = _checked(seconds, errors)
    as_good = seconds[errors <= own_error]
    return float(own_seconds / as_good.min()) if len(as_good) else 0.0


def _checked(seconds, errors):
    seconds, errors = np.asarray(seconds, float), np.asarray(errors, float)
    if seconds.ndim != 1 or seconds.shape != errors.shape:
        raise ValueError(f"seconds and errors must have one shape (n,), got {seconds.shape} and {errors.shape}")
    return seconds, errors
