"""A picture of shapes with exact edges: each pixel takes of a colour what the shape covers of it.

Points are x, y in units of the canvas, y upward; `scale` pixels to the unit. Blender has no plotting library, and this
is all that a chart needs of one.
"""

from __future__ import annotations

import struct
import zlib
from itertools import pairwise

import numpy as np

from ...kernels.maps.coverage import edge_coverage

_ROUND = 16  # sides of a disc as small as a line is wide


class Canvas:
    """width, height in units; colours are sRGB triples, 0 to 1."""

    def __init__(self, width, height, scale=2.0, paper=(1.0, 1.0, 1.0)):
        self.width, self.height, self.scale = width, height, scale
        self.pixels = np.empty((round(height * scale), round(width * scale), 3))
        self.pixels[:] = paper

    def fill(self, polygons, colour, alpha=1.0):
        """Fill polygons, each (n,2) or all (k,n,2), whichever way round; where they overlap they count once."""
        corners = [np.asarray(polygon, float) * self.scale for polygon in polygons]
        if not corners:
            return
        corners = [polygon if _area(polygon) > 0 else polygon[::-1] for polygon in corners]
        starts = np.concatenate(corners)
        ends = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in corners])
        height, width, _ = self.pixels.shape
        low = np.maximum(np.floor(starts.min(0)).astype(int), 0)
        high = np.minimum(np.ceil(starts.max(0)).astype(int) + 1, (width, height))
        if (high <= low).any():
            return
        shape = high[1] - low[1], high[0] - low[0]
        weights = np.ones((1, len(starts)))
        covered = edge_coverage((starts - low).T.copy(), (ends - low).T.copy(), weights, shape)[0]
        covered = alpha * np.clip(covered, 0, 1)[..., None]
        window = self.pixels[low[1] : high[1], low[0] : high[0]]
        window += covered * (np.asarray(colour) - window)

    def line(self, points, colour, width=1.0, alpha=1.0, dash=None):
        """Draw a line through points (n,2), with round ends; dash: lengths of strokes and of gaps."""
        points = np.asarray(points, float)
        parts = [points] if dash is None else _dashes(points, *dash)
        polygons = []
        for part in parts:
            polygons += [_bar(a, b, width) for a, b in pairwise(part) if (a != b).any()]
            if dash is None:
                polygons += [_disc(point, width / 2, _ROUND) for point in part]
        self.fill(polygons, colour, alpha)

    def disc(self, x, y, radius, colour, alpha=1.0):
        """Fill a disc."""
        self.fill([_disc(np.array([x, y]), radius, 48)], colour, alpha)

    def star(self, x, y, radius, colour):
        """Fill a star of five points."""
        turn = np.pi / 2 + np.arange(10) * np.pi / 5
        reach = np.where(np.arange(10) % 2, 0.42 * radius, radius)
        # Its ten corners go once round, so that its area is that of a polygon.
        self.fill([np.stack([x + reach * np.cos(turn), y + reach * np.sin(turn)], 1)], colour)

    def box(self, x, y, width, height, colour, alpha=1.0):
        """Fill a rectangle from its lower left corner."""
        self.fill([np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])], colour, alpha)

    def png(self):
        """The picture as the bytes of a PNG file (ISO/IEC 15948), eight bits a channel."""
        rows = np.round(np.clip(self.pixels[::-1], 0, 1) * 255).astype(np.uint8)
        height, width, _ = rows.shape
        # Each row says that it is not filtered.
        raw = np.concatenate([np.zeros((height, 1), np.uint8), rows.reshape(height, -1)], axis=1).tobytes()
        head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
        parts = (b"IHDR", head), (b"IDAT", zlib.compress(raw, 9)), (b"IEND", b"")
        return b"\x89PNG\r\n\x1a\n" + b"".join(_part(name, body) for name, body in parts)


def _part(name, body):
    return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))


def _area(polygon):
    x, y = polygon.T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def _disc(middle, radius, sides):
    turn = np.arange(sides) * 2 * np.pi / sides
    return middle + radius * np.stack([np.cos(turn), np.sin(turn)], 1)


def _bar(a, b, width):
    """The rectangle of a line from a to b."""
    along = (b - a) / np.linalg.norm(b - a)
    across = np.array([-along[1], along[0]]) * width / 2
    return np.stack([a - across, b - across, b + across, a + across])


def _dashes(points, stroke, gap):
    """Strokes along a line."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    parts = []
    for begin in np.arange(0.0, at[-1], stroke + gap):
        end = min(begin + stroke, at[-1])
        inner = at[(at > begin) & (at < end)]
        where = np.concatenate([[begin], inner, [end]])
        parts.append(np.stack([np.interp(where, at, points[:, k]) for k in (0, 1)], 1))
    return parts
