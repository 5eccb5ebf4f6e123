"""One step of the walk: from the edge by which the curve enters a triangle to the one by which it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..halfedges import AFTER, BEFORE
from .conic import ACROSS, conic, edge_crossings, edge_root, follow, has_double_root, tangent, weights_on_edge
from .lit_surface import g_at


@dataclass
class Exit:
    """Where curves (n,) leave triangles: over, the half-edge across the exit, -1 for none; share along the exit;
    corners (2,n), the records of its tail and head, and ends (2,n), g there; m and n, three arrays (n,) each, of the
    point."""

    over: np.ndarray
    share: np.ndarray
    corners: np.ndarray
    ends: np.ndarray
    m: list
    n: list


def step(surface, entry, p, ends, corners):
    """Exit of the curve from triangles entered through half-edges `entry` (n,), for p (3,n); ends (2,n) is g at the
    records `corners` (2,n), the tail and the head of the entry; and those (k,) for which it does not hold.

    With one crossing in and one out the sign of g at the third corner decides; the others have more, see `follow_all`.
    """
    tip, after, before, bound = surface.ways.take(entry, axis=0).T
    tip = tip.astype(np.intp)
    g_tip = g_at(surface.plan.take(tip, axis=0), p[0], p[1])
    below = ends[0] < 0
    ahead = (g_tip < 0) == below  # the sign changes between head and tip, else between tip and tail
    one_sided = (ends[1] < 0) == below
    third = g_tip - np.where(ahead, ends[0], ends[1])  # along the edge that the curve passes by
    some = np.flatnonzero(one_sided | (np.abs(third) < bound.view(np.float32)))
    some = some[one_sided[some] | _twice(surface, entry[some], ahead[some], g_tip[some], ends[:, some])]
    over = np.where(ahead, after, before).astype(np.intp)
    exits, g = np.empty_like(corners), np.empty_like(ends)
    for table, new, at_tip in ((corners, exits, tip), (ends, g, g_tip)):
        new[0], new[1] = np.where(ahead, table[1], at_tip), np.where(ahead, at_tip, table[0])
    share, m, n = _crossing(surface, exits, g)
    return Exit(over, share, exits, g, m, n), some


def _crossing(surface, corners, ends):
    """Share (n,) at which g, `ends` (2,n) at records `corners` (2,n), crosses zero between them; M and N there, three
    arrays (n,) each."""
    here, way = surface.plan.take(corners[0], axis=0), surface.plan.take(corners[1], axis=0)
    way -= here
    share = edge_root(*ends, way[:, 2] * way[:, 1] - way[:, 3] * way[:, 0])
    low, lift = surface.rise.take(corners[0], axis=0), surface.rise.take(corners[1], axis=0)
    lift -= low
    mx, my, nx, ny = (here[:, c] + share * way[:, c] for c in range(4))
    mz, nz = (low[:, c] + share * lift[:, c] for c in range(2))
    return share, [mx, my, mz], [nx, ny, nz]


def _twice(surface, entry, ahead, g_tip, ends):
    """Whether (n,) the curve crosses twice the edge that it passes by, between the tip and the entry's tail, if
    `ahead`, or its head."""
    triangle, edge = np.divmod(entry, 3)
    third = 3 * triangle + np.where(ahead, BEFORE[edge], AFTER[edge])
    return has_double_root(np.where(ahead, g_tip, ends[1]), np.where(ahead, ends[0], g_tip), surface.k[third])


def follow_all(surface, entry, s, p):
    """As `step`, for any number of crossings, along the conic from share s (n,) of the entry; those (k,) for which it
    does not hold are torn: the curve does not pass their entry, because the normals jump across it."""
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
    share = np.nan_to_num(shares[row, index], nan=0.5)
    return _through(surface, triangle, index // 2, share, p), np.flatnonzero(torn | ~some)


def _through(surface, triangle, edge, share, p):
    """The Exit at share (n,) of edges (n,) of triangles (n,) for p (3,n)."""
    leave = 3 * triangle + edge
    corners = np.stack([surface.tail[leave], surface.head[leave]])
    m, n = surface.at(triangle, weights_on_edge(edge, share))
    return Exit(surface.over[leave], share, corners, surface.g_at_ends(leave, p), m, n)
