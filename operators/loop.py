"""Sequences that repeat without a seam: find the period of what moves, or blend the end into the start.

Blended frame k of the first n is w of frame k and 1 - w of the frame that follows the last, w = k / n: the loop goes
through every join as the animation does, and its light is the mean, so weighted, of the light that was baked.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass

import numpy as np

from .errors import DappleError
from .extract import read_scene
from .mesh_arrays import TopologyCache
from .timeline import Timeline

_SAME = 0.05  # of what moves from one frame to the next: less is not seen


@dataclass(frozen=True)
class Loop:
    """frames: for each frame of the sequence the baked frames that it is made of, (number, weight) each; repeats:
    whether the last is followed by the first without a seam; by: a sentence on how it was come by."""

    frames: tuple[tuple[tuple[int, float], ...], ...]
    repeats: bool
    by: str


def as_they_are(numbers) -> Loop:
    """The frames of these numbers, with no thought of a loop."""
    return Loop(tuple(((number, 1.0),) for number in numbers), False, "as baked")


def looped(context, request, numbers, blend) -> Loop:
    """The Loop of consecutive frame numbers: one period of what moves, where there is one and no blend is asked for;
    else the last `blend` frames blended into the first, a quarter of all where that is None.

    Raises DappleError for frames with gaps, and for too few of them.
    """
    gaps = sorted(set(range(numbers[0], numbers[-1])) - set(numbers))
    if gaps:
        raise DappleError(f"Frame {gaps[0]} is not baked: a loop needs all frames from {numbers[0]} to {numbers[-1]}.")
    period = None if blend else find_period(context, request, numbers[0], len(numbers))
    if period:
        kept = as_they_are(numbers[:period]).frames
        return Loop(kept, True, f"what moves repeats after {period} frames, from frame {numbers[0]} on")
    return blended(numbers, blend or max(len(numbers) // 4, 1))


def blended(numbers, count) -> Loop:
    """The frames but the last `count`, which are blended into the first ones."""
    kept = len(numbers) - count
    if kept < count:
        raise DappleError(f"{len(numbers)} frames are too few to blend {count} of them; bake at least {2 * count}.")
    mixed = [
        ((a, k / count), (b, 1 - k / count)) for k, (a, b) in enumerate(zip(numbers, numbers[kept:], strict=False))
    ]
    mixed[0] = ((numbers[kept], 1.0),)
    frames = (*mixed, *(((number, 1.0),) for number in numbers[count:kept]))
    return Loop(frames, True, f"the last {count} frames are blended into the first")


def find_period(context, request, first, most):
    """After how many frames from `first` on all that the light depends on is again where it was, and moves on as it
    did; None where that takes more than `most` frames. All of it is read, nothing is solved."""
    timeline, topology = Timeline(context), TopologyCache()

    def at(number):
        scene, _ = read_scene(timeline.at(number), request.water, request.receivers, topology, request.volume)
        return list(_numbers(scene))

    try:
        start, following = at(first), at(first + 1)
        steps = _distances(start, following)
        if steps is None or not any(steps):
            return most if steps is not None else None  # it stands still, or changes its topology
        before = following
        for period in range(2, most + 1):
            now = at(first + period + 1)
            if _near(before, start, steps) and _near(now, following, steps):
                return period
            before = now
    finally:
        timeline.restore()
    return None


def _numbers(thing):
    """The arrays of numbers in a Scene, in a fixed order."""
    if is_dataclass(thing):
        for one in fields(thing):
            yield from _numbers(getattr(thing, one.name))
    elif isinstance(thing, (tuple, list)):
        for one in thing:
            yield from _numbers(one)
    elif isinstance(thing, (float, np.ndarray)) and np.asarray(thing).dtype.kind == "f":
        yield np.asarray(thing)


def _distances(one, other):
    """The root mean square difference of each pair of arrays; None where they do not have the same shapes."""
    if [a.shape for a in one] != [b.shape for b in other]:
        return None
    return [float(np.sqrt(np.mean((a - b) ** 2))) if a.size else 0.0 for a, b in zip(one, other, strict=True)]


def _near(one, other, steps):
    """Whether two frames differ by little, array by array, beside what moves from a frame to the next."""
    distances = _distances(one, other)
    if distances is None:
        return False
    rest = 1e-6 * max(steps)  # of what stands still
    return all(d <= _SAME * step + rest for d, step in zip(distances, steps, strict=True))
