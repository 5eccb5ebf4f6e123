"""`dapple chart`: the words of the command, and a line for each run that is measured."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..bake.bake import request_from_scene
from ..errors import DappleError
from .make import chart


def add_words(commands, names, peers=()):
    """Add `chart` to the commands of a parser; names: the type of names between commas; peers: what joins the chart."""
    from ...kernels.methods import METHODS

    about = "Measure every method on one frame of the open scene, and draw error against time."
    words = commands.add_parser("chart", help="error against time of every method", description=about)
    words.add_argument("--frame", type=int, help="default: the scene's current frame")
    words.add_argument("--resolution", type=int, help="texels along each side of a map; default: the scene's")
    words.add_argument("--out", help="folder of chart.png, needs.png, chart.csv and chart.json; default: the maps'")
    words.add_argument("--rungs", type=names, metavar="METHOD,...", help=f"of auto, {', '.join(METHODS)}; default: all")
    words.add_argument("--water", type=names, metavar="OBJECT,...", help="default: the scene's")
    words.add_argument("--receivers", type=names, metavar="OBJECT,...", help="default: the scene's")
    words.set_defaults(run=lambda words: run(words, peers))


def run(words, peers=()):
    """Make the chart that the words ask for; returns the exit code. Raises DappleError for what cannot be measured."""
    from ...kernels.chart.ladder import AUTO, METHODS

    frame = bpy.context.scene.frame_current if words.frame is None else words.frame
    request = request_from_scene(bpy.context.scene, words.water, words.receivers, (frame,), words.out)
    if words.resolution is not None:
        request = replace(request, settings=replace(request.settings, resolution=words.resolution))
    unknown = sorted(set(words.rungs or ()) - {*METHODS, AUTO})
    if unknown:
        raise DappleError(f"There is no rung '{unknown[0]}'; name some of {AUTO}, {', '.join(METHODS)}.")
    steps, before = chart(bpy.context, request, words.rungs, peers), ""
    while True:
        try:
            sentence = next(steps)
        except StopIteration as end:
            print(f"The chart is in {end.value[0]}, with {end.value[1].name} and {end.value[2].name} beside it")
            return 0
        if sentence and sentence != before:
            print(sentence, flush=True)
            before = sentence
