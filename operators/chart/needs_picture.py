"""needs.png: what the light of a scene loses without each physical term, and what the term costs."""

from __future__ import annotations

import numpy as np

from ...kernels.chart.ladder import PRESETS
from .canvas import Canvas
from .lettering import lettering
from .plot import FAINT, GRID, INK, plain, power

WIDTH, SCALE, _ROW = 920, 1.5, 34
_LEFT, _RIGHT, _COST = 190, 690, 800
_LEAST, _MOST = -7, 0  # powers of ten of the changes shown
_TOLD = 0.05  # less of the time than this is no more than one run differs from another by
_NEEDED, _SPARED = (0.84, 0.37, 0.00), (0.72, 0.72, 0.75)
_NAMES = {
    "fresnel": "Fresnel's losses",
    "absorption": "absorption",
    "dispersion": "dispersion",
    "disc": "the sun's disc",
    "occlusion": "shadows of objects",
    "second_crossing": "meeting water again",
    "reflection": "reflection off water",
    "reconstruction": "the smooth surface",
}


def draw(needs, title, line, tolerance):
    """The bytes of needs.png of Needs, for light that is good to a tolerance."""
    needs = sorted(needs, key=lambda need: -need.change)
    height = 150 + _ROW * len(needs)
    canvas, top = Canvas(WIDTH, height, SCALE), height - 105
    with lettering() as letters:
        letters.draw(canvas, 24, height - 34, title, 19, INK)
        letters.draw(canvas, 24, height - 55, line, 11, FAINT)
        letters.draw(canvas, _LEFT, top + 14, "error of the light without it", 11, INK)
        letters.draw(canvas, _COST, top + 14, "its part of the time", 11, INK, 0.5)
        _draw_axis(canvas, letters, top, top - _ROW * len(needs))
        for k, need in enumerate(needs):
            _draw_need(canvas, letters, need, top - _ROW * (k + 0.5), tolerance)
    return canvas.png()


def _at(change):
    """Where a change lies across the picture."""
    part = (np.log10(max(change, 10.0**_LEAST)) - _LEAST) / (_MOST - _LEAST)
    return _LEFT + float(np.clip(part, 0, 1)) * (_RIGHT - _LEFT)


def _draw_axis(canvas, letters, top, bottom):
    """Powers of ten, and the presets between them."""
    for exponent in range(_LEAST, _MOST + 1):
        x = _at(10.0**exponent)
        canvas.line([(x, bottom), (x, top)], GRID, 0.8)
        letters.draw(canvas, x, bottom - 15, power(exponent), 11, INK, 0.5)
    for name, tolerance in PRESETS.items():
        x = _at(tolerance)
        canvas.line([(x, bottom - 20), (x, top)], FAINT, 0.8, dash=(2, 3))
        letters.draw(canvas, x, bottom - 31, name, 10, FAINT, 0.5)


def _draw_need(canvas, letters, need, y, tolerance):
    """A term's name, bar, change and cost."""
    needed = need.change > tolerance
    letters.draw(canvas, _LEFT - 10, y - 4, _NAMES.get(need.term, need.term), 12, INK, 1.0)
    end = _at(need.change)
    if end > _LEFT:
        canvas.box(_LEFT, y - 9, end - _LEFT, 18, _NEEDED if needed else _SPARED)
    text = plain(need.change) if need.change > 0 else "none"
    width = letters.width(text, 11)
    canvas.box(end + 3, y - 6, width + 8, 13, (1, 1, 1), 0.9)
    letters.draw(canvas, end + 6, y - 4, text, 11, INK)
    share = need.seconds / need.of if need.of > 0 else 0.0
    cost = f"{share:.0%}" if abs(share) >= _TOLD else "hardly any"
    letters.draw(canvas, _COST, y - 4, cost, 12, INK, 0.5)
