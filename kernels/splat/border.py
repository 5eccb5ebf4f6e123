"""Beams that straddle a border - of a chart, an object or a shadow: cut where their rays change sides.

Of the three corners one lands on one side and two on the other. The border is found on the two edges between them by
bisection with rays, and taken as straight in between; the lone corner's piece is a triangle, the rest a quadrilateral.
"""

from __future__ import annotations

import numpy as np

_STEPS = 8  # bisections, of edges a texel long or less: the border is found to 1 / 2^8 texel
_ASIDE = 0.4  # of the distance of two points on the map: of a jump, one side is half of it off the middle
_SAG = 0.05  # texels: how far off the cut may be; of parts smaller than a texel, of their size

# Per lone corner: the six nodes (corners 0-2, middles 3-5 of the edges from them) in the order that puts it first.
_TURNS = np.array([[0, 1, 2, 3, 4, 5], [1, 2, 0, 4, 5, 3], [2, 0, 1, 5, 3, 4]]).T


def straddlers(chart):
    """Which (n,) triangles one straight border can cut, by the sides chart (6,n) of their nodes, and the order (6,n) of
    their nodes that puts the lone corner first."""
    a, b, c = chart[:3]
    order = _TURNS[:, np.where(b == c, 0, np.where(a == c, 1, 2))]
    side = np.take_along_axis(chart, order, axis=0)
    one, other = side[:2]
    two = (one != other) & (side[2] == other) & (side[4] == other)
    two &= ((side[3] == one) | (side[3] == other)) & ((side[5] == one) | (side[5] == other))
    return two, order


def cut(lander, nodes, six, shade, size, wide):
    """Where the border crosses both edges from the lone corner, six[0], of triangles six (6,n), see `straddlers`;
    size (n,) [texel]: how large they are; wide (n,) [texel]: what of them is wider on the map may be torn by a seam.

    Returns, for the edges to the second and third corner, the share (n,) of the edge on the lone corner's side, and the
    Nodes just before and just behind the border; and (n,) whether only the two sides were met.
    """
    count = six.shape[1]
    near, far = nodes.take(np.tile(six[0], 2)), nodes.take(six[1:3].ravel())  # both edges at once
    one, other = near.chart, far.chart
    low, high, sound = np.zeros(2 * count), np.ones(2 * count), np.ones(2 * count, bool)
    m0, dm, n0, dn = near.m, far.m - near.m, near.n, far.n - near.n
    for _ in range(_STEPS + int(np.ceil(np.log2(size.max(initial=1.0))))):
        middle = (low + high) / 2
        found = lander.land(m0 + middle * dm, n0 + middle * dn, np.tile(shade, 2))
        before = found.chart == one
        sound &= before | (found.chart == other)
        low, high = np.where(before, middle, low), np.where(before, high, middle)
        near, far = near.where(before, found), far.where(~before, found)
    share = (low + high) / 2
    crossings = [(share[k], near.take(k), far.take(k)) for k in (slice(0, count), slice(count, None))]
    (_, near_s, far_s), (_, near_t, far_t) = crossings
    alone, second, third = (nodes.take(six[k]) for k in range(3))
    sound = sound.reshape(2, -1).all(0)
    for corners in ((alone, near_s, near_t), (far_s, far_t, third, second)):
        sound &= _whole(lander, corners, shade, wide)
    sag = _SAG / np.maximum(size, 1.0)
    return crossings, sound & _straight(lander, nodes, six, shade, sag, crossings)


def _whole(lander, corners, shade, wide):
    """Whether (n,) corners of polygons, of one chart or of none, are no further apart on the map than `wide` (n,), or
    what lies halfway between two of them lands between them."""
    spans = (np.ptp([getattr(c, name) for c in corners], axis=0) for name in ("x", "y"))
    whole = (corners[0].chart < 0) | (np.maximum(*spans) <= wide)
    at = np.flatnonzero(~whole)
    if len(at):
        whole[at] = True
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True):
            a, b = a.take(at), b.take(at)
            middle = lander.land((a.m + b.m) / 2, (a.n + b.n) / 2, shade[at])
            off = np.hypot(middle.x - (a.x + b.x) / 2, middle.y - (a.y + b.y) / 2)
            whole[at] &= (middle.chart == a.chart) & (off <= _ASIDE * np.hypot(a.x - b.x, a.y - b.y))
    return whole


def _straight(lander, nodes, six, shade, sag, crossings):
    """Whether (n,) the border between the crossings of both edges is as straight as it is taken to be: halfway, a point
    `sag` (n,) of the way to the lone corner lies on its side, one as far to the others on theirs."""
    (_, near_s, far_s), (_, near_t, far_t) = crossings
    one, other = near_s.chart, far_s.chart
    straight = np.ones(len(one), bool)
    for side, ends, corners in ((one, (near_s, near_t), six[:1]), (other, (far_s, far_t), six[1:3])):
        point = []
        for name in ("m", "n"):
            middle = (getattr(ends[0], name) + getattr(ends[1], name)) / 2
            corner = sum(np.take(getattr(nodes, name), c, axis=1) for c in corners) / len(corners)
            point.append(middle + sag * (corner - middle))
        straight &= lander.land(*point, shade).chart == side
    return straight
