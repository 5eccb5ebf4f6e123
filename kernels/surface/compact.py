"""Normals and curvatures at vertices where the water is no height field: from relations along the edges alone.

Along an edge of length L, in the frame of its chord, the slopes s and second derivatives H of a smooth surface obey

    (s_i + s_j) / 2 = L (H_j - H_i) / 12          to the fourth power of L,
    s_j - s_i       = L (H_i + H_j) / 2           to the third, along the edge and across,
    H_j - H_i       = 0                           to the first,

as those of cubics do [1]. The tilts of all normals against the mesh's, and the second fundamental forms, are those that
obey them best: weighted least squares, by conjugate gradients with the vertices' own blocks as preconditioner. Nothing
but an edge's ends enters, so that folds as narrow as a few edges do no harm to each other.

[1] Lele 1992, Compact finite difference schemes with spectral-like resolution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_NEAREST = 0.05  # weight of the first relation: 1 over the squared length, in median lengths, and this
_CHANGE, _EVEN = 0.02, 1e-4  # of the second, times the first one's root; and of the third
_HELD = 1e6  # weight of a tilt that is to be none
_ROUNDING = 1e-12
_STEPS = 12
_TURN = 0.7  # cosine: least between the normals at an edge's ends, most between these and the edge; else not resolved
_NOISE = 0.25  # of the tilts: where the relations are off by more, noise is what they follow


@dataclass(frozen=True)
class Tangents:
    """Of vertices (n,): unit normals (3,n); turns (3,3,n), the normal's change along a unit step in the tangent plane;
    sound (n,) bool, whether the mesh resolves a smooth surface there."""

    vertices: np.ndarray
    normals: np.ndarray
    turns: np.ndarray
    sound: np.ndarray


def compact(positions, normals, triangles, held):
    """The Tangents at the vertices of triangles (T,3), of positions and unit normals (3,V); held (V,) bool: the normals
    that are right as they are."""
    vertices, local = np.unique(triangles, return_inverse=True)
    local = local.reshape(-1, 3)
    p, n, held = positions[:, vertices].T, normals[:, vertices].T, held[vertices]
    edges, smooth = _edges(local, p, n)
    frames = _frames(n)
    rows, right, root, unit = _relations(p, n, frames, edges[smooth])
    x = _solve(rows, right, edges[smooth], np.where(held, _HELD, 0.0))
    misfit = ((rows[:, 1] * x[edges[smooth]].reshape(-1, 10)).sum(1) - right[:, 1]) / root[:, 1]
    sound = np.ones(len(vertices), bool)
    sound[edges[~smooth]] = False
    sound[local[~sound[local].all(1)]] = False
    tilt = np.hypot(x[:, 0], x[:, 1])[~held & sound]
    if len(tilt) and len(misfit):
        sound &= np.median(np.abs(misfit)) <= _NOISE * np.median(tilt)
    tilted = n + x[:, :1] * frames[:, 0] + x[:, 1:2] * frames[:, 1]
    tilted = np.where(held[:, None], n, tilted / np.sqrt((tilted**2).sum(1, keepdims=True)))
    form = x[:, [2, 3, 3, 4]].reshape(-1, 2, 2) / unit
    turns = -np.einsum("vki,vkl,vlj->ijv", frames, form, frames, optimize=True)
    return Tangents(vertices, tilted.T, turns, sound)


def _edges(triangles, p, n):
    """Edges (E,2) of triangles, and whether (E,) they lie on a smooth surface, by points and normals p, n (V,3)."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    keys, count = np.unique(pairs[:, 0] * len(n) + pairs[:, 1], return_counts=True)
    edges = np.stack(np.divmod(keys, len(n)), 1)
    chord = p[edges[:, 1]] - p[edges[:, 0]]
    off = np.max([np.abs((n[edges[:, k]] * chord).sum(1)) for k in range(2)], axis=0)
    aligned = (n[edges[:, 0]] * n[edges[:, 1]]).sum(1) > _TURN
    return edges, (count <= 2) & aligned & (off <= _TURN * np.sqrt((chord**2).sum(1)))


def _frames(normals):
    """Two unit tangents (V,2,3) at unit normals (V,3)."""
    axis = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    u = np.cross(axis, normals)
    u /= np.maximum(np.sqrt((u**2).sum(1, keepdims=True)), np.finfo(float).tiny)
    return np.stack([u, np.cross(normals, u)], 1)


def _relations(p, n, frames, edges):
    """Rows (E,6,10), right sides (E,6), roots of the weights in both (E,6), and the unit of length, of the relations
    along edges (E,2). The unknowns at either end are the tilts along its two tangents, and the second fundamental form
    in them, times that unit."""
    chord = p[edges[:, 1]] - p[edges[:, 0]]
    length = np.maximum(np.sqrt((chord**2).sum(1)), np.finfo(float).tiny)
    along = chord / length[:, None]
    up = n[edges].sum(1)
    up -= (up * along).sum(1, keepdims=True) * along
    up /= np.sqrt((up**2).sum(1, keepdims=True))
    unit = float(np.median(length)) if len(length) else 1.0
    rows, right, step = np.zeros((len(edges), 6, 10)), np.zeros((len(edges), 6)), (length / unit)[:, None]
    for k, sign in enumerate((-1, 1)):
        (s, s_tilt), (t, t_tilt), forms = _end(n[edges[:, k]], frames[edges[:, k]], along, np.cross(up, along), up)
        tilts, form = slice(5 * k, 5 * k + 2), slice(5 * k + 2, 5 * k + 5)
        rows[:, 0, tilts], rows[:, 1, tilts], rows[:, 2, tilts] = s_tilt / 2, sign * s_tilt, sign * t_tilt
        right -= np.stack([s / 2, sign * s, sign * t, *np.zeros((3, len(s)))], 1)
        rows[:, 0, form] = -sign * step * forms[0] / 12
        rows[:, 1, form], rows[:, 2, form] = -step * forms[0] / 2, -step * forms[1] / 2
        for j, of in enumerate(forms):
            rows[:, 3 + j, form] = sign * step * of
    slopes = 1 / (step[:, 0] ** 2 + _NEAREST)
    root = np.sqrt(np.stack([slopes, *[_CHANGE * np.sqrt(slopes)] * 2, *[np.full(len(edges), _EVEN)] * 3], 1))
    return rows * root[:, :, None], right * root, root, unit


def _end(n, frame, along, across, up):
    """At one end of edges, in the frames along, across and up (E,3): slopes along and across with their derivatives
    (E,2) by the tilts, and the rows (E,3) by which the second fundamental form gives the second derivatives."""
    rise = (n * up).sum(1)
    leaning = np.einsum("eki,ei->ek", frame, up)

    def slope(direction):
        s = -(n * direction).sum(1) / rise
        return s, -(np.einsum("eki,ei->ek", frame, direction) + s[:, None] * leaning) / rise[:, None]

    (s, s_tilt), (t, t_tilt) = slope(along), slope(across)
    a, b = (np.einsum("eki,ei->ek", frame, v + h[:, None] * up) for v, h in ((along, s), (across, t)))
    forms = [
        np.stack([v[:, 0] * w[:, 0], v[:, 0] * w[:, 1] + v[:, 1] * w[:, 0], v[:, 1] * w[:, 1]], 1) / rise[:, None]
        for v, w in ((a, a), (a, b), (b, b))
    ]
    return (s, s_tilt), (t, t_tilt), forms


def _solve(rows, right, edges, held):
    """Unknowns (V,5) that obey rows (E,6,10), right sides (E,6), best; held (V,): weight of no tilt."""
    count, five = len(held), np.arange(5)
    blocks = rows.transpose(0, 2, 1) @ rows
    ends = edges.T.ravel()

    def gathered(values, width):
        at = ends[:, None] * width + np.arange(width)
        return np.bincount(at.ravel(), values.reshape(-1, width).ravel(), count * width)

    own = gathered(np.concatenate([blocks[:, :5, :5], blocks[:, 5:, 5:]]), 25).reshape(count, 5, 5)
    own[:, five, five] += _ROUNDING
    own[:, five[:2], five[:2]] += held[:, None]
    inverse, other = np.linalg.inv(own), blocks[:, :5, 5:]
    to = (rows * right[:, :, None]).sum(1)
    residual = gathered(np.concatenate([to[:, :5], to[:, 5:]]), 5).reshape(count, 5, 1)
    x, scaled = np.zeros_like(residual), inverse @ residual
    along, rho = scaled, (residual * scaled).sum()
    for _ in range(_STEPS):
        if rho <= 0:
            break
        far = np.concatenate([other @ along[edges[:, 1]], other.transpose(0, 2, 1) @ along[edges[:, 0]]])
        image = own @ along + gathered(far, 5).reshape(count, 5, 1)
        step = rho / (along * image).sum()
        x, residual = x + step * along, residual - step * image
        scaled = inverse @ residual
        rho, before = (residual * scaled).sum(), rho
        along = scaled + rho / before * along
    return x[:, :, 0]
