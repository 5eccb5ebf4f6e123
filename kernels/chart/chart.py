"""The chart of a scene: every rung at several settings, judged by one reference, with the time that each takes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..anchor import Kept
from ..methods import prepare, solve
from ..terms import left_in
from .clock import pinned, timed
from .ladder import AUTO, rungs
from .maps import light_of
from .pareto import front, over_front
from .reference import reference

_PATIENCE = 15.0  # CPU s: a rung that took longer is asked for nothing finer


@dataclass(frozen=True)
class Row:
    """One run. rung, label: what it is called; method: which one ran; asked: its tolerance, None where it knows none;
    seconds: CPU s, the median of `runs`; error: mean squared error over the mean square, as tolerances count;
    by_mean: the same over the squared mean; mae: mean absolute error over the mean; energy: relative error of the flux;
    flip: mean HDR-FLIP, None where nothing can tell; estimated: what the method says of its error; reason: why auto
    took it; peer: whether it is no method of ours; seen: the part of the texels that it was judged on; on_front:
    whether no other rung is both as quick and as good; below_floor: the error is less than that of the reference;
    over_front: of auto, its time over that of the quickest rung that is as good, 0 where none is."""

    rung: str
    label: str
    method: str
    asked: float | None
    seconds: float
    runs: int
    error: float
    by_mean: float
    mae: float
    energy: float
    flip: float | None = None
    estimated: float | None = None
    reason: str = ""
    peer: bool = False
    seen: float = 1.0
    on_front: bool = False
    below_floor: bool = False
    over_front: float | None = None


@dataclass
class Chart:
    """rows; the Reference; needs: the Needs of the scene's physical terms, if they were measured; sentences on what was
    not measured and why."""

    reference: object
    rows: list = field(default_factory=list)
    needs: list = field(default_factory=list)
    notes: list = field(default_factory=list)


def build(scene, texels, settings, methods=None, flip=None):
    """Yield a sentence on each step; returns the Chart of a Scene on Texels for Settings.

    methods: names of METHODS or auto, None for all. flip: a function of Texels, true and found light (K,3), that
    returns a mean FLIP. Raises ValueError as `methods.solve` does.
    """
    settings = replace(settings, match_cycles=False, reuse=0.0)
    with pinned():
        chart = Chart((yield from reference(scene, texels, settings)))
        judge = _Judge(chart.reference, texels, flip)
        for rung in rungs(scene, settings, methods):
            yield from _climb(rung, scene, texels, settings, judge, chart)
    chart.rows = marked(chart.rows, chart.reference.error)
    return chart


def join(chart, scene, texels, settings, peers, flip=None):
    """Let peers join a Chart of `build`; yields a sentence on each step.

    peers: functions of a Scene, Settings and Texels that yield pairs of a sentence and, once there is one, what makes a
    `Row`: a dict with `light` (K,3) and, where that is not all, `seen` (K,) bool.
    """
    judge = _Judge(chart.reference, texels, flip)
    for peer in peers:
        for sentence, run in peer(*left_in(scene, settings), texels):
            if run is None:
                yield sentence
                continue
            chart.rows.append(judge.row(**run, peer=True))
            yield f"{sentence}, error {chart.rows[-1].error:.2g}"
    chart.rows = marked(chart.rows, chart.reference.error)


def _climb(rung, scene, texels, settings, judge, chart):
    """Measure a rung's points, one after the other; yields a sentence on each."""
    kept = Kept(prepare(scene, texels, settings))
    for number, (label, own) in enumerate(rung.settings(settings)):
        if rung.method == AUTO:  # an animation's plan is for its tolerance
            kept = Kept(prepare(scene, texels, own))
        seconds, solution, runs = timed(lambda own=own, kept=kept: _anew(scene, texels, own, kept))
        work = solution.diagnostics
        asked = own.tolerance if any("tolerance" in changed for _, changed in rung.knobs) else None
        row = judge.row(
            light_of(texels, solution.images),
            rung=rung.name,
            label=label,
            method=work.method,
            asked=asked,
            seconds=seconds,
            runs=runs,
            estimated=work.estimated_error,
            reason=work.reason if rung.method == AUTO else "",
        )
        chart.rows.append(row)
        yield f"{rung.name}, {label}: {seconds:.3g} s, error {row.error:.2g}"
        left = len(rung.knobs) - number - 1
        if seconds > _PATIENCE and left:
            chart.notes.append(f"{rung.name}: {left} finer settings were left out, as the last took {seconds:.0f} s")
            return


def _anew(scene, texels, settings, kept):
    """The Solution of a frame whose lamps are not those of the frame before."""
    kept.forget_light()
    return solve(scene, texels, settings, kept)


class _Judge:
    """Makes Rows by a Reference."""

    def __init__(self, truth, texels, flip):
        self._maps, self._texels, self._flip = truth.maps, texels, flip

    def row(self, light, seen=None, **known):
        """A Row for light (K,3), judged where it is `seen`."""
        maps = self._maps
        judged = {
            "error": maps.error(light, seen=seen),
            "by_mean": maps.error_by_mean(light, seen=seen),
            "mae": maps.mean_error(light, seen=seen),
            "energy": maps.energy(light, seen=seen),
            "seen": 1.0 if seen is None else float(np.mean(seen)),
        }
        if self._flip is not None and seen is None:
            judged["flip"] = self._flip(self._texels, maps.light, light)
        return Row(**known, **judged)


def marked(rows, floor):
    """The Rows with on_front, below_floor and over_front; errors below that of the reference count as alike."""
    seconds = np.array([row.seconds for row in rows])
    errors = np.maximum([row.error for row in rows], floor)
    ladder = np.array([row.rung != AUTO for row in rows], bool)
    on = np.zeros(len(rows), bool)
    on[ladder] = front(seconds[ladder], errors[ladder])
    own = ladder & ~np.array([row.peer for row in rows], bool)
    return [
        replace(
            row,
            on_front=bool(on[k]),
            below_floor=row.error < floor,
            over_front=None if ladder[k] else over_front(seconds[k], errors[k], seconds[own], errors[own]),
        )
        for k, row in enumerate(rows)
    ]
