"""Axes in powers of ten on a Canvas: where values lie, grid lines and their names, labels that find room."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

INK, FAINT, GRID = (0.15, 0.15, 0.17), (0.45, 0.45, 0.48), (0.89, 0.89, 0.90)
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SIDES = tuple(
    (turn, away) for away in (8, 16, 26, 40) for turn in (0.0, 0.125, -0.125, 0.5, 0.25, -0.25, 0.375, -0.375)
)


def power(exponent):
    """10 to a whole exponent, in writing."""
    plain = {-2: "0.01", -1: "0.1", 0: "1", 1: "10", 2: "100"}
    return plain.get(exponent, "10" + str(exponent).translate(_SUPERSCRIPT))


def plain(value):
    """A number to one digit, in writing."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{value:.1g}" if int(exponent) >= -3 else f"{digit} × {power(int(exponent))}"


@dataclass
class Plot:
    """canvas, letters; frame: left, bottom, right, top on the canvas; x, y: least and greatest value of each axis."""

    canvas: object
    letters: object
    frame: tuple
    x: tuple
    y: tuple
    _taken: list = field(default_factory=list)

    def at(self, x, y):
        """Where values lie on the canvas: (n,2) of x (n,) and y (n,)."""
        left, bottom, right, top = self.frame
        across = _part(x, self.x) * (right - left) + left
        up = _part(y, self.y) * (top - bottom) + bottom
        return np.stack(np.broadcast_arrays(across, up), -1)

    def grid(self, x_name, y_name):
        """Draw lines at powers of ten, short ones between them, and the names of the axes."""
        left, bottom, right, top = self.frame
        for exponent in _exponents(self.x):
            x, _ = self.at(10.0**exponent, self.y[0])
            self.canvas.line([(x, bottom), (x, top)], GRID, 0.8)
            self.letters.draw(self.canvas, x, bottom - 15, power(exponent), 11, INK, 0.5)
        for exponent in _exponents(self.y):
            _, y = self.at(self.x[0], 10.0**exponent)
            self.canvas.line([(left, y), (right, y)], GRID, 0.8)
            self.letters.draw(self.canvas, left - 7, y - 4, power(exponent), 11, INK, 1.0)
        for x, y in self.at(_between(self.x), self.y[0]):
            self.canvas.line([(x, y), (x, y + 4)], FAINT, 0.6)
        for x, y in self.at(self.x[0], _between(self.y)):
            self.canvas.line([(x, y), (x + 4, y)], FAINT, 0.6)
        self.canvas.line([(left, top), (left, bottom), (right, bottom)], INK, 1.0)
        self.letters.draw(self.canvas, (left + right) / 2, bottom - 34, x_name, 12, INK, 0.5)
        self.letters.draw(self.canvas, left - 42, (bottom + top) / 2, y_name, 12, INK, 0.5, upright=True)

    def take(self, points, radius, weight=1.0):
        """Keep labels off points (n,2) of the canvas, as far as there is room."""
        for x, y in np.atleast_2d(points):
            self._taken.append((x - radius, y - radius, x + radius, y + radius, weight))

    def take_line(self, points):
        """Keep labels off a line through points (n,2) of the canvas."""
        for a, b in pairwise(points):
            steps = max(2, int(np.linalg.norm(b - a) / 5))
            self.take(a + (b - a) * np.linspace(0, 1, steps)[:, None], 2.0, 0.3)

    def label(self, points, text, size, colour):
        """Write a text beside one of points (n,2), the first for choice, where it covers least."""
        width, best = self.letters.width(text, size), None
        for rank, (x, y) in enumerate(np.atleast_2d(points)):
            for turn, away in _SIDES:
                box = _beside(x, y, turn, away, width, size)
                cost = self._cost(box) + 0.02 * away + 0.25 * rank
                if best is None or cost < best[0]:
                    best = cost, box, (x, y), away
        _, box, (x, y), away = best
        if away > 16:
            near = np.clip([x, y], box[:2], box[2:])
            self.canvas.line([(x, y), near], colour, 0.6, 0.6)
        self.canvas.box(box[0] - 1, box[1] - 1, width + 2, size + 2, (1, 1, 1), 0.75)
        self.letters.draw(self.canvas, box[0], box[1] + 0.24 * size, text, size, colour)
        self._taken.append((*box, 6.0))

    def _cost(self, box):
        """How much of what is drawn a box covers; far more for what sticks out of the frame."""
        left, bottom, right, top = self.frame
        out = max(left + 2 - box[0], bottom + 2 - box[1], box[2] - right, box[3] - top, 0.0)
        hits = (w for a, b, c, d, w in self._taken if box[0] < c and a < box[2] and box[1] < d and b < box[3])
        return 10 * (out > 0) + out + sum(hits)


def _beside(x, y, turn, away, width, size):
    """left, bottom, right, top of a text `away` from a point in a direction, in turns from the right upward."""
    across, up = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    left = x + away * across - width * (1 - across) / 2
    bottom = y + away * up - size * (1 - up) / 2
    return left, bottom, left + width, bottom + size


def _part(values, ends):
    low, high = np.log10(ends)
    return (np.log10(np.asarray(values, float)) - low) / (high - low)


def _exponents(ends):
    low, high = np.log10(ends)
    return range(int(np.ceil(low - 1e-9)), int(np.floor(high + 1e-9)) + 1)


def _between(ends):
    low, high = (int(np.floor(v)) for v in np.log10(ends))
    values = [k * 10.0**e for e in range(low, high + 1) for k in range(2, 10)]
    return [v for v in values if ends[0] <= v <= ends[1]]


def reach(values, least, pad=1.6):
    """Least and greatest value of an axis that shows `values`, at least a factor of `least` apart."""
    low, high = min(values) / pad, max(values) * pad
    grow = np.sqrt(max(least * low / high, 1.0))
    return low / grow, high * grow
