"""Sequences that repeat without a seam: find the period of what moves, or blend the end into the start.

Blended frame k of the first n is w of frame k and 1 - w of the frame that follows the last, w = k / n: the loop goes
through every join as the animation does, and its light is the mean, so weighted, of the light that was baked.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass

import numpy as np

from ..bake.timeline import Timeline
from ..errors import DappleError
from ..read.extract import read_scene
from ..read.mesh_arrays import TopologyCache

_SAME = 0.05  # of what moves from one frame to the next: less is not seen
_JERK = 1.5  # times the largest change of speed on the way


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
    """After how many frames from `first` on all that the light depends on is again where it was, and comes to it as it
    leaves it; None where that takes more than `most` frames. All of it is read, nothing is solved.

    No frame after the return is looked at: what is keyed stands still there.
    """
    timeline, topology = Timeline(context), TopologyCache()

    def at(number):
        scene, _ = read_scene(timeline.at(number), request.water, request.receivers, topology, request.volume)
        return list(_numbers(scene))

    try:
        start, here = at(first), at(first + 1)
        seam, before = _Seam(start, here), start
        if not seam.moves:
            return most
        for period in range(2, most + 1):
            before, here = here, at(first + period)
            if not seam.fits(before, here):
                return None
            if seam.closes(before, here):
                return period
            seam.learn(before, here)
    finally:
        timeline.restore()
    return None


class _Seam:
    """Whether frames lead back to the first, by arrays of numbers: their steps from frame to frame, and how these
    change, beside the largest of both that were seen on the way."""

    def __init__(self, start, following):
        self._start, self._following, self._last = start, following, start
        self._rest = [1e-6 * float(np.abs(a).max(initial=0)) for a in start]  # rounding
        self._steps = _distances(start, following) if self.fits(following) else [np.inf]
        self.moves = any(step > rest for step, rest in zip(self._steps, self._rest, strict=False))
        self._bends = [0.0] * len(start)

    def fits(self, *frames):
        """Whether the frames have as many vertices of all as the first."""
        return all([a.shape for a in frame] == [a.shape for a in self._start] for frame in frames)

    def learn(self, before, here):
        """Take in a frame on the way, and the one before."""
        self._steps = list(map(max, self._steps, _distances(before, here)))
        self._bends = list(map(max, self._bends, _changes(self._last, before, here)))
        self._last = before

    def closes(self, before, here):
        """Whether a frame is where the first is, and the first goes on from the one before it without a jerk."""
        apart = zip(_distances(here, self._start), self._steps, self._rest)
        jerks = zip(_changes(before, self._start, self._following), self._bends, self._rest)
        return all(d <= _SAME * step + rest for d, step, rest in apart) and all(
            bend <= _JERK * most + rest for bend, most, rest in jerks
        )


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
    """The root mean square difference of each pair of arrays."""
    return [_size(a - b) for a, b in zip(one, other)]


def _changes(before, here, after):
    """By how much the steps to a frame and from it differ, root mean square of each array."""
    return [_size(c - 2 * b + a) for a, b, c in zip(before, here, after)]


def _size(difference):
    return float(np.sqrt(np.mean(difference**2))) if difference.size else 0.0
