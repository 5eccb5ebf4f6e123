"""One step of the walk: from the edge by which the curve enters a triangle to the one by which it leaves."""

from __future__ import annotations

import numpy as np

from .conic import (
    ACROSS,
    conic,
    edge_crossings,
    edge_root,
    follow,
    has_double_root,
    tangent,
    weights_on_edge,
)


def step(surface, entry, s, p, ends):
    """Exit of the curve from triangles entered through half-edges `entry` (n,) at share s (n,), for p (3,n); ends (2,n)
    is g at the tail and the head of the entry.

    Returns the exit half-edge (n,), its share (n,), g at its ends (2,n) and torn (n,) bool: the curve does not pass the
    entry here, because the normals jump across it. In the common case, one crossing in and one out, the sign of g at
    the third corner decides; triangles with more crossings are followed along the conic.
    """
    g_tail, g_head = ends
    g_tip = surface.g(np.take(surface.tip, entry), p[0], p[1])
    after, before = np.take(surface.after, entry), np.take(surface.before, entry)
    ahead = (g_tip < 0) == (g_tail < 0)  # the sign changes between head and tip, else between tip and tail
    leave, pass_by = np.where(ahead, after, before), np.where(ahead, before, after)
    ends = np.stack([np.where(ahead, g_head, g_tip), np.where(ahead, g_tip, g_tail)])
    share = edge_root(*ends, np.take(surface.k, leave))
    twice = has_double_root(np.where(ahead, g_tip, g_head), np.where(ahead, g_tail, g_tip), np.take(surface.k, pass_by))
    special = np.flatnonzero(twice | ((g_tail < 0) == (g_head < 0)))
    torn = np.zeros(len(entry), bool)
    if len(special):
        leave[special], share[special], torn[special] = _step_along(surface, entry[special], s[special], p[:, special])
        ends[:, special] = surface.g_at_ends(leave[special], p[:, special])
    return leave, share, ends, torn


def _step_along(surface, entry, s, p):
    """As `step`, for any number of crossings."""
    triangle, edge = np.divmod(entry, 3)
    row = np.arange(len(entry))
    corner_m, corner_n = surface.corners(triangle)
    g = surface.g_at_corners(triangle, p[0], p[1])
    shares = edge_crossings(g, surface.k.reshape(-1, 3)[triangle])
    away = np.abs(shares[row, edge] - s[:, None])
    torn = np.isnan(away).all(1)
    column = np.where(np.isnan(away), np.inf, away).argmin(1)
    here = np.where(torn, s, shares[row, edge, column])
    shares[row, edge, column] = np.nan
    start = weights_on_edge(edge, here)[:, 1:].T
    coefficients = conic(corner_m, corner_n, p[0], p[1])
    along, gradient = tangent(coefficients, *start)
    inward = ACROSS[edge]
    along = along * np.where(along[0] * inward[:, 0] + along[1] * inward[:, 1] < 0, -1.0, 1.0)
    shares = shares.reshape(-1, 6)
    index, some = follow(coefficients, start, along, gradient, shares, g)
    return 3 * triangle + index // 2, np.nan_to_num(shares[row, index], nan=0.5), torn | ~some
