"""Make the chart of one frame: read the scene, let a worker measure, draw, write. Nothing is written before the end."""

from __future__ import annotations

import sys

from ..bake.bake import check
from ..bake.messages import Died, Failed, Stage
from ..bake.pool import Pool
from ..bake.remarks import check_maps
from ..bake.timeline import Timeline
from ..errors import DappleError
from ..maps.write import check_folder
from ..read.extract import read_scene
from ..read.mesh_arrays import TopologyCache
from .job import Charted, ChartJob
from .record import written

_SLICE = 0.2  # s between looks for Ctrl-C
_KILLED = "the process that measured ended before it was done (code {}), most likely for want of memory."


def chart(context, request, methods=None, peers=(), wait=_SLICE):
    """Yield sentences on what is done, "" after `wait` seconds of nothing; returns the Paths of what was written.

    request: a BakeRequest for one frame; methods: names of methods, None for all; peers: see `kernels.chart`. Closed
    early, it leaves nothing behind. Raises DappleError for what cannot be measured.
    """
    check(request)
    check_folder(request.out)
    (number,) = request.frames
    scene, warnings = _read(context, request, number)
    with Pool(1) as pool:
        pool.give(ChartJob(number, scene, request.settings, methods))
        done = None
        while not isinstance(done, Charted):
            said = pool.answers(wait)
            for _, done in said:
                yield _sentence(number, done)
            if not said:
                yield ""
    found = done.chart
    if peers:
        from ...kernels.chart.chart import join
        from .flip import flip

        yield from join(found, scene, done.texels, request.settings, peers, flip())
    yield "drawing"
    return written(request, number, scene, found, warnings)


def _read(context, request, number):
    """(Scene, warnings) of a frame, with the scene left as it was."""
    timeline = Timeline(context)
    try:
        read = read_scene(timeline.at(number), request.water, request.receivers, TopologyCache(), request.volume)
    finally:
        timeline.restore()
    names = [receiver.name for receiver in read[0].receivers]
    check_maps(names, [request.settings.resolution] * len(names))
    return read


def _sentence(number, answer):
    """What to say of a worker's answer; raises DappleError where it failed."""
    if isinstance(answer, Stage):
        return answer.text
    if isinstance(answer, Charted):
        return "measured"
    if isinstance(answer, Died):
        raise DappleError(f"Frame {number}: {_KILLED.format(answer.code)}")
    if isinstance(answer, Failed) and answer.details:
        print(answer.details, file=sys.stderr)
    raise DappleError(f"Frame {number}: {answer.sentence}")
