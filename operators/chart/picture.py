"""chart.png: error against time of every rung, with what there is to say beside the curves that it is said of."""

from __future__ import annotations

import numpy as np

from ...kernels.chart.ladder import AUTO, PRESETS
from .canvas import Canvas
from .lettering import lettering
from .plot import FAINT, INK, Plot, plain, reach

WIDTH, HEIGHT, SCALE = 920, 600, 1.5
_FRAME = 74, 62, 890, 498
# Okabe and Ito's colours, which the colour-blind tell apart.
_COLOURS = {
    "flat": (0.00, 0.45, 0.70),
    "sun_map": (0.80, 0.47, 0.65),
    "caustic_map": (0.00, 0.62, 0.45),
    "photon_splat": (0.84, 0.37, 0.00),
    "photon_splat, mesh as it is": (0.80, 0.60, 0.45),
    "conic_walk": (0.34, 0.24, 0.55),
    "conic_walk, first root": (0.34, 0.71, 0.91),
    AUTO: INK,
}
_PEER = (0.42, 0.42, 0.42)
_X_AXIS = "CPU seconds for the frame, on one core (left is quicker)"
_Y_AXIS = "error, as Tolerance counts it (down is better)"
_TOUCH = 14.0  # stars that are nearer than this have one label
_AMISS = 0.05  # of the light: where more is missing, or too much, the curve says so
_WORST = 30.0  # errors above are drawn here


def draw(chart, title, lines):
    """The bytes of chart.png of a Chart; lines: what is said under the title."""
    canvas = Canvas(WIDTH, HEIGHT, SCALE)
    with lettering() as letters:
        letters.draw(canvas, 24, HEIGHT - 34, title, 19, INK)
        for k, line in enumerate(lines):
            letters.draw(canvas, 24, HEIGHT - 55 - 15 * k, line, 11, FAINT)
        floor = max(chart.reference.error, 1e-9)
        errors = [min(max(row.error, floor), _WORST) for row in chart.rows]
        ends = [*errors, *PRESETS.values(), floor]
        plot = Plot(canvas, letters, _FRAME, reach([row.seconds for row in chart.rows], 30, 2.0), reach(ends, 30))
        plot.grid(_X_AXIS, _Y_AXIS)
        _draw_floor(plot, floor)
        _draw_presets(plot)
        _draw_front(plot, chart.rows, floor)
        _draw_curves(plot, chart.rows, floor)
    return canvas.png()


def _places(plot, rows, floor):
    """Where rows lie on the canvas (n,2)."""
    errors = np.clip([row.error for row in rows], floor, _WORST)
    return plot.at([row.seconds for row in rows], errors)


def _draw_floor(plot, floor):
    """Shade what the reference cannot tell."""
    left, bottom, right, _ = plot.frame
    _, top = plot.at(plot.x[0], floor)
    plot.canvas.box(left + 1, bottom + 1, right - left - 1, top - bottom - 1, (0.93, 0.93, 0.94))
    text = f"below {plain(floor)}, the reference's own error, nothing can be told"
    plot.letters.draw(plot.canvas, right - 6, bottom + 5, text, 10, FAINT, 1.0)
    across = np.arange(right - 6 - plot.letters.width(text, 10), right, 12)
    plot.take(np.stack([across, np.full_like(across, bottom + 9)], -1), 6.0)


def _draw_presets(plot):
    """A line at each preset's tolerance."""
    left, _, right, _ = plot.frame
    for name, tolerance in PRESETS.items():
        _, y = plot.at(plot.x[0], tolerance)
        plot.canvas.line([(left, y), (right, y)], (0.62, 0.62, 0.66), 0.8, dash=(2, 3))
        text = f"{name}: {tolerance:g}"
        plot.letters.draw(plot.canvas, right - 2, y + 3, text, 10, FAINT, 1.0)
        width = plot.letters.width(text, 10)
        plot.take([(right - width / 2, y + 7)], width / 2, 3.0)


def _draw_front(plot, rows, floor):
    """The stairs along what no other rung beats."""
    best = sorted((row for row in rows if row.on_front), key=lambda row: row.seconds)
    if not best:
        return
    places = _places(plot, best, floor)
    corners = [(places[0][0], plot.frame[3])]
    for place in places:
        corners += [(place[0], corners[-1][1]), tuple(place)]
    corners.append((plot.frame[2], corners[-1][1]))
    plot.canvas.line(corners, (0.99, 0.86, 0.40), 5.0, 0.9)
    plot.take_line(np.array(corners))
    # Between two steps, where the curves are not.
    plot.label(np.array(corners[-2:]).mean(0)[None], "best for its time", 10.5, (0.62, 0.47, 0.0))


def _draw_curves(plot, rows, floor):
    """Curves, points, stars, then names, which keep off all of these."""
    named = {}
    for row in rows:
        named.setdefault(row.rung, []).append(row)
    for name, own in named.items():
        places = _places(plot, own, floor)
        colour = _colour(own[0])
        if name != AUTO:
            plot.canvas.line(places, colour, 1.5)
            plot.take_line(places)
        plot.take(places, 5.0)
        for row, (x, y) in zip(own, places):
            _mark(plot.canvas, row, x, y, colour)
    for name, own in named.items():
        places = _places(plot, own, floor)
        if name != AUTO:
            plot.label(places[[-1, 0]], name + _share(own[-1]), 11.5, _colour(own[0]))
    for rows in _together(plot, named.get(AUTO, ()), floor):
        plot.label(_places(plot, rows, floor), f"auto, {' + '.join(row.label for row in rows)}", 11.5, INK)


def _share(row):
    """What part of the light a row has, where it is not nearly all."""
    return f": {100 * (1 + row.energy):.0f} % of the light" if abs(row.energy) > _AMISS else ""


def _together(plot, rows, floor):
    """Lists of rows whose marks touch, which one label is for."""
    groups = []
    for row, place in zip(rows, _places(plot, rows, floor)):
        near = [g for g in groups if np.linalg.norm(_places(plot, g, floor) - place, axis=1).min() < _TOUCH]
        if near:
            near[0].append(row)
        else:
            groups.append([row])
    return groups


def _mark(canvas, row, x, y, colour):
    """The mark of one row: a star for auto, a square for a peer, a dot; hollow where the reference cannot tell."""
    if row.rung == AUTO:
        canvas.star(x, y, 8.5, (1, 1, 1))
        canvas.star(x, y, 7.0, INK)
    elif row.peer:
        canvas.box(x - 3.2, y - 3.2, 6.4, 6.4, colour)
    else:
        canvas.disc(x, y, 4.4, colour)
    if row.below_floor and row.rung != AUTO:
        canvas.disc(x, y, 2.6, (1, 1, 1))


def _colour(row):
    return _PEER if row.peer else _COLOURS.get(row.rung, INK)
