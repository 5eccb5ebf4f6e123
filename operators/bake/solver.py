"""What a worker does with a frame: texels, light, and the files of the maps. Runs without Blender."""

from __future__ import annotations

import time
import traceback

from ...kernels.sequence import Sequence
from ..chart.job import ChartJob
from ..chart.job import answers as chart_answers
from ..errors import DappleError
from ..maps.exr_encode import encode
from .messages import Failed, Job, Rough, Solved, Stage
from .shared import TexelCache

_MEMORY = "there is not enough memory for it; set a lower resolution, fewer workers, or a coarser water mesh."
_FAULT = "the solver failed with '{}'. This is a fault of Dapple's; please report it with the lines in the console."


class Solver:
    """Solves the frames of one bake, in whatever order they come; what it keeps between them saves time only, but for
    the light that Settings.reuse asks to keep."""

    def __init__(self):
        self._texels, self._sequence = None, None

    def answers(self, job: Job | ChartJob):
        """Yield the Stages of a Job, a Rough for each picture that it asks for, and last an Anchor or Solved, or
        Failed; of a ChartJob the Stages and last a Charted, or Failed."""
        try:
            yield from self._steps(job)
        except (DappleError, ValueError) as error:
            yield Failed(str(error), "" if isinstance(error, DappleError) else traceback.format_exc())
        except MemoryError:
            yield Failed(_MEMORY)
        except Exception as error:
            yield Failed(_FAULT.format(f"{type(error).__name__}: {error}"), traceback.format_exc())

    def _steps(self, job):
        if isinstance(job, ChartJob):
            return chart_answers(job)
        return self._anchor(job) if job.anchor is None else self._frame(job)

    def _anchor(self, job):
        from ...kernels import methods

        yield Stage("first look")
        yield methods.prepare(job.scene, self._charts(job), job.settings)

    def _frame(self, job):
        from ...kernels import methods

        clock = Clock()
        yield Stage("texels")
        texels = self._charts(job)
        clock.lap("texels")
        if self._sequence is None:
            self._sequence = Sequence(methods.solve, job.settings, job.anchor)
        yield Stage("light")
        for solution in self._sequence.rough(job.scene, texels) if job.rough else ():
            yield Rough(_files(solution, job.full))
        solution = self._sequence.solve(job.number, job.scene, texels)
        clock.lap("solve")
        yield Stage("maps")
        files = _files(solution, job.full)
        clock.lap("write")
        yield Solved(files, solution.diagnostics, clock.seconds)

    def _charts(self, job):
        """The Texels of a Job's receivers."""
        self._texels = self._texels or TexelCache(job.settings.padding)
        receivers = job.scene.receivers
        return tuple(map(self._texels.of, receivers, job.sizes or [job.settings.resolution] * len(receivers)))


class Clock:
    """Seconds from lap to lap."""

    def __init__(self):
        self.seconds = {}
        self._last = time.perf_counter()

    def lap(self, stage):
        now = time.perf_counter()
        self.seconds[stage], self._last = now - self._last, now


def _files(solution, full):
    return tuple(encode(image, full) for image in solution.images)
