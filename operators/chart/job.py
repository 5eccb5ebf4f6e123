"""The chart as a job for a worker: measured by a process that does nothing else. Runs without Blender."""

from __future__ import annotations

from dataclasses import dataclass

from ...kernels.scene import Scene, Settings
from ..messages import Stage
from ..shared import TexelCache


@dataclass(frozen=True)
class ChartJob:
    """A frame to make the chart of, by its number, for a Scene and Settings; methods: names, None for all."""

    number: int
    scene: Scene
    settings: Settings
    methods: tuple | None


@dataclass(frozen=True)
class Charted:
    """The Chart of a frame, and the Texels that it is for."""

    chart: object
    texels: tuple


def answers(job):
    """Yield a Stage for each step of a ChartJob, and last its Charted."""
    from ...kernels.chart.chart import build
    from .flip import flip

    texels = TexelCache(job.settings)
    charts = tuple(texels.of(receiver) for receiver in job.scene.receivers)
    steps = build(job.scene, charts, job.settings, job.methods, flip())
    while True:
        try:
            yield Stage(next(steps))
        except StopIteration as end:
            yield Charted(end.value, charts)
            return
