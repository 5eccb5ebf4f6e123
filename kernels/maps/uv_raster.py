"""Which UV triangle owns which texel.

A triangle owns the texels whose centres it holds; a texel that charts only touch goes to the nearest triangle. All
coordinates are in texel units, centres at integer + 1/2.
"""

from __future__ import annotations

import numpy as np

_BLOCK = 1 << 18  # candidate texels at once: bounds the memory
_REACH = 0.71  # texels: no triangle further than half a diagonal from a centre touches the texel


def cross2(a, b):
    """z of the cross product of plane vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def owners(corners, usable, resolution):
    """Owning triangle of each texel.

    corners (T,3,2) in texel units; usable (T,) bool, False leaves a triangle out. Returns owner (resolution^2,) int,
    -1 where no triangle's box reaches, and centred (resolution^2,) bool, True where the owner holds the centre.
    """
    owner = np.full(resolution**2, -1, np.int64)
    nearest = np.full(resolution**2, np.inf)
    index = np.flatnonzero(usable)
    low = np.clip(np.floor(corners[index].min(1)), 0, resolution - 1).astype(np.int64)
    high = np.clip(np.ceil(corners[index].max(1)), low + 1, resolution).astype(np.int64)
    size = high - low
    for block in _blocks(size.prod(1)):
        parent, texel = _candidates(low[block], size[block], resolution)
        parent, texel, distance = _claims(corners[index[block]], parent, texel, nearest, resolution)
        owner[texel] = index[block][parent]
        nearest[texel] = distance
    return owner, nearest == 0


def touching(corners, resolution):
    """(triangle, flat texel) of every texel that triangles corners (T,3,2) touch, and a few that they barely miss;
    triangles may leave the image."""
    low = np.floor(corners.min(1))
    high = np.floor(corners.max(1)) + 1
    seen = np.flatnonzero(((high > 0) & (low < resolution)).all(1))
    low = np.clip(low[seen], 0, resolution - 1).astype(np.int64)
    size = np.clip(high[seen], 1, resolution).astype(np.int64) - low
    pairs = []
    for block in _blocks(size.prod(1)):
        parent, texel = _candidates(low[block], size[block], resolution)
        row, column = np.divmod(texel, resolution)
        near = _edge_distances(column + 0.5, row + 0.5, corners[seen[block]], parent).min(0) > -_REACH
        pairs.append((seen[block][parent[near]], texel[near]))
    if not pairs:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])


def barycentrics(points, corners):
    """Barycentric coordinates (n,3) of points (n,2) in triangles corners (n,3,2), clamped to the nearest point of each
    triangle, and the squared distance (n,) to it, 0 inside."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area2 = cross2(b - a, c - a)
    inner = np.stack([cross2(b - points, c - points), cross2(c - points, a - points)], 1) / area2[:, None]
    inner = np.column_stack([inner, 1 - inner.sum(1)])
    outside = np.flatnonzero((inner < 0).any(1))
    distance = np.zeros(len(points))
    if len(outside):
        inner[outside], distance[outside] = _nearest_on_edges(points[outside], corners[outside])
    return inner, distance


def _nearest_on_edges(points, corners):
    """Barycentrics and squared distance of the point of each triangle's rim that is nearest to points."""
    best = np.full(len(points), np.inf)
    bary = np.zeros((len(points), 3))
    for e in range(3):
        a, b = corners[:, e], corners[:, (e + 1) % 3]
        edge = b - a
        length2 = np.maximum((edge**2).sum(1), np.finfo(float).tiny)
        s = np.clip(((points - a) * edge).sum(1) / length2, 0, 1)
        d = ((a + s[:, None] * edge - points) ** 2).sum(1)
        better = d < best
        best[better] = d[better]
        bary[better] = 0
        bary[better, e] = 1 - s[better]
        bary[better, (e + 1) % 3] = s[better]
    return bary, best


def _blocks(counts):
    """Slices of consecutive triangles of about _BLOCK candidates each."""
    total = np.cumsum(counts)
    cuts = np.searchsorted(total, np.arange(_BLOCK, total[-1] if len(total) else 0, _BLOCK)) + 1
    return [slice(a, b) for a, b in zip([0, *cuts], [*cuts, len(counts)], strict=True) if b > a]


def _candidates(low, size, resolution):
    """(box, flat texel) of every texel in boxes of `size` (n,2) from `low` (n,2)."""
    count = size.prod(1)
    parent = np.repeat(np.arange(len(low)), count)
    rank = np.arange(len(parent)) - np.repeat(np.cumsum(count) - count, count)
    row, column = np.divmod(rank, size[parent, 0])
    return parent, (low[parent, 1] + row) * resolution + low[parent, 0] + column


def _claims(corners, triangle, texel, nearest, resolution):
    """The candidates nearer to their texel's centre than `nearest`, the nearest last: (triangle, texel, distance)."""
    row, column = np.divmod(texel, resolution)
    inner = _edge_distances(column + 0.5, row + 0.5, corners, triangle).min(0)
    near = np.flatnonzero((inner > -_REACH) & (nearest[texel] > 0))
    distance = np.zeros(len(near))
    outside = inner[near] < 0
    rim = near[outside]
    centres = np.column_stack([column[rim], row[rim]]) + 0.5
    distance[outside] = barycentrics(centres, corners[triangle[rim]])[1]
    better = distance < nearest[texel[near]]
    near, distance = near[better], distance[better]
    order = np.argsort(-distance, kind="stable")
    return triangle[near[order]], texel[near[order]], distance[order]


def _edge_distances(x, y, corners, triangle):
    """Signed distances (3,n) of points from the lines of triangles' edges, positive inside, in texels."""
    edge = corners[:, [1, 2, 0]] - corners
    length = np.maximum(np.linalg.norm(edge, axis=2), np.finfo(float).tiny)
    turn = np.sign(cross2(edge[:, 0], edge[:, 1]))[:, None] / length
    nx, ny = -edge[:, :, 1] * turn, edge[:, :, 0] * turn
    offset = nx * corners[:, :, 0] + ny * corners[:, :, 1]
    return np.stack([nx[triangle, e] * x + ny[triangle, e] * y - offset[triangle, e] for e in range(3)])
