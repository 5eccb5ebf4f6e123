"""CPU seconds of a run: one process, pinned to one core, warm."""

from __future__ import annotations

import contextlib
import os
import statistics
import time

_SHORT = 1.0  # s: longer runs are not repeated
_REPEATS = 3


@contextlib.contextmanager
def pinned():
    """Keep this thread on one core, where the system can; other code pays for no move between caches."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


def timed(run):
    """(CPU seconds of run(), what it returned, how many runs that is the median of).

    A run that takes less than a second is repeated, and its first, cold, is not counted.
    """
    seconds, result = _once(run)
    if seconds >= _SHORT:
        return seconds, result, 1
    again = [_once(run)[0] for _ in range(_REPEATS)]
    return statistics.median(again), result, _REPEATS


def _once(run):
    start = time.process_time()
    result = run()
    return time.process_time() - start, result
