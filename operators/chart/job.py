"""The chart as a job for a worker: measured by a process that does nothing else. Runs without Blender."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ...kernels.scene import Scene, Settings
from ..bake.messages import Stage
from ..bake.shared import TexelCache

_LONG = 2.0  # CPU s: solves that take longer are timed once, not three times


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
    """Yield a Stage for each step of a ChartJob, and last its Charted; with what the scene needs, if all rungs are
    asked for."""
    from ...kernels.chart.chart import build
    from ...kernels.chart.ladder import AUTO
    from ...kernels.plan.needs import needs
    from .flip import flip

    texels = TexelCache(job.settings.padding)
    charts = tuple(texels.of(receiver, job.settings.resolution) for receiver in job.scene.receivers)
    steps = build(job.scene, charts, job.settings, job.methods, flip())
    chart = None
    while chart is None:
        try:
            yield Stage(next(steps))
        except StopIteration as end:
            chart = end.value
    plain = replace(job.settings, match_cycles=False, reuse=0.0)
    long = any(row.rung == AUTO and row.seconds > _LONG for row in chart.rows)
    for need in needs(job.scene, charts, plain, repeats=1 if long else 3) if job.methods is None else ():
        chart.needs.append(need)
        yield Stage(f"without {need.term.replace('_', ' ')}: error {need.change:.2g}, {-need.seconds:+.3g} s")
    yield Charted(chart, charts)
