"""What a scene needs: each physical term, by what the light loses without it, and by what it costs.

The light is solved in full and once more without each term. A change far below the tolerance is a term that the scene
does not need; one that a receiver gets all its light by changes that receiver by 1, however little others see of it.
"""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass, replace

import numpy as np

from ..methods import solve
from ..status import Status
from ..terms import TERMS


@dataclass(frozen=True)
class Need:
    """term: a key of `terms.TERMS`; change: mean squared change of the light without it, over the mean square of the
    light; worst: the same on the receiver that changes most; seconds: CPU time that it costs, below 0 where leaving it
    out costs more; of: CPU seconds of the full solve."""

    term: str
    change: float
    worst: float
    seconds: float
    of: float


def needs(scene, texels, settings, kept=None, repeats=3):
    """Yield the Need of each term that a Scene on Texels and Settings has, by the complete method; kept: as of
    `methods.solve`. Times are medians of `repeats` runs that take turns with the full solve's."""
    settings = replace(settings, method="photon_splat")
    solve(scene, texels, settings, kept)  # what is kept between frames is made now
    for term in TERMS:
        if term in settings.without or not _has(scene, settings, term):
            continue
        less = replace(settings, without=(*settings.without, term))
        runs = [(_timed(scene, texels, settings, kept), _timed(scene, texels, less, kept)) for _ in range(repeats)]
        full, without = (statistics.median(seconds) for seconds in zip(*((a[1], b[1]) for a, b in runs), strict=True))
        yield Need(term, *_change(runs[0][0][0], runs[0][1][0]), full - without, full)


def _timed(scene, texels, settings, kept):
    """The Solution and its CPU seconds."""
    if kept is not None:
        kept.forget_light()
    start = time.process_time()
    answer = solve(scene, texels, settings, kept)
    return answer, time.process_time() - start


def _has(scene, settings, term):
    """Whether there is anything to leave out."""
    water = len(scene.water.triangles) > 0
    glass = any(np.any(getattr(c.material, "sigma_a", 0.0)) for c in scene.casters)
    present = {
        "fresnel": water,
        "second_crossing": water,
        "reflection": water,
        "absorption": bool(np.any(scene.sigma_a)) or glass,
        "dispersion": bool(settings.dispersion),
        "disc": any(getattr(light, "angle", 0.0) > 0 for light in scene.lights),
        "reconstruction": water and settings.surface == "auto",
        "occlusion": water or bool(scene.occluders),
    }
    return present.get(term, True)


def _change(whole, part):
    """Mean squared difference of two Solutions over the mean square of the first, and the largest of one receiver."""
    squares, powers = [], []
    for one, other, status in zip(whole.images, part.images, whole.status, strict=True):
        owned = status != Status.EMPTY
        squares.append(float(((one - other)[owned] ** 2).sum()))
        powers.append(float((one[owned] ** 2).sum()))
    each = [s / p if p > 0 else 0.0 for s, p in zip(squares, powers, strict=True)]
    return (sum(squares) / sum(powers) if sum(powers) > 0 else 0.0), max(each, default=0.0)
