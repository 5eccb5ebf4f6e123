"""On which side of the water a point lies."""

from __future__ import annotations

import numpy as np


def under_water(water, point):
    """Whether a point (3,) sees more of the Water's underside than of its top, by solid angle.

    The top is the side that is up on the whole; of a closed body of water, the side that its triangles face. Seen from
    outside, a closed body shows as much of one as of the other.
    """
    soup = water.positions[water.triangles] - point
    across = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    up, size = across[:, 2].sum(), np.abs(across).sum()
    angle = solid_angle(soup)
    seen = angle.sum() * (-1 if up < -1e-9 * size else 1)
    return bool(seen > 1e-6 * np.abs(angle).sum())


def solid_angle(soup):
    """Solid angles (T,) [sr] of triangles (T,3,3) from the origin, negative for those that it sees wound
    counter-clockwise, on their own side. Van Oosterom & Strackee 1983."""
    a, b, c = (soup[:, k] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    bulk = la * lb * lc + (a * b).sum(1) * lc + (a * c).sum(1) * lb + (b * c).sum(1) * la
    return 2 * np.arctan2((a * np.cross(b, c)).sum(1), bulk)
