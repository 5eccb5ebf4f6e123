"""Closed meshes that are convex but for dents: what leaves them outwards never meets them again.

Grids on round things have quads whose corners lie in no plane. Where such a quad is split along the wrong diagonal, its
two triangles make a dent, which the other diagonal closes. A mesh counts if no triangle is of two dents and the mesh
with all of them closed is convex: it is seen whole from within, once round about, and no edge of it is bent inwards.
So the mesh is that body less thin tetrahedra, one for each dent, and light that sets out in a dent meets nothing but
its other side, and that only if it leaves by less than the angle between the two.
"""

from __future__ import annotations

import numpy as np

from ..facets import cross
from ..halfedges import AFTER, BEFORE, build_twins
from ..optics import dot

_BENT = 1e-5  # over the extent: an edge turned inwards by so much times its triangle's altitude; along a way it adds up
_LOOK = np.array([[0.5377], [0.2914], [0.7912]])  # some direction, along no axis
_CLEAN = -2.0  # less than any cosine
_TINY = np.finfo(float).tiny


def dents(positions, triangles, facet):
    """Sines (T,) of the dents that triangles (T,3) of positions (V,3) are part of, -2 for those of none; None if the
    mesh is not convex with its dents closed. facet (3,T): unit normals out of what it encloses."""
    corner = np.ascontiguousarray(triangles.T, np.int64)
    points = np.ascontiguousarray(positions.T)
    points = points - points.take(corner, 1).mean((1, 2))[:, None]
    twins = _closed(points, corner, facet)
    if twins is None:
        return None
    inwards = np.flatnonzero(_bent(points, corner, facet, twins))
    inwards = inwards[inwards < twins[inwards]]
    sine = np.full(len(triangles), _CLEAN)
    if not len(inwards):
        return sine
    one, other = (facet.take(h // 3, 1) for h in (inwards, twins[inwards]))
    across = cross(one, other)
    angle = np.sqrt(dot(across, across))
    pair = np.stack([inwards, twins[inwards]]) // 3
    if np.bincount(pair.ravel()).max() > 1 or dot(one, other).min() < 0:
        return None
    sine[pair] = angle
    shut, facet = _shut(points, corner, facet, inwards, twins[inwards])
    twins = _closed(points, shut, facet)
    return None if twins is None or _bent(points, shut, facet, twins).any() else sine


def _closed(points, corner, facet):
    """The twins (3T,) of a mesh that is closed, wound one way, and seen whole and once from the origin, else None.

    points (3,V); corner (3,T) into them; facet (3,T), as all that is asked here."""
    a, b, c = v = points.take(corner, 1).swapaxes(0, 1)
    if corner.shape[1] < 4 or dot(facet, a).min() <= 0:
        return None
    along = dot(cross(b - a, c - a), facet)
    side = 1.0 if along[0] > 0 else -1.0
    beside = np.cross(points, side * _LOOK, axis=0).take(corner, 1).swapaxes(0, 1)
    looked = np.logical_and.reduce([dot(v[k], beside[AFTER[k]]) > 0 for k in range(3)])
    if (side * along).min() <= 0 or np.count_nonzero(looked) != 1:
        return None
    twins = build_twins(corner.T)
    if (twins < 0).any():
        return None
    return twins if (corner[AFTER].T.ravel() == corner.T.ravel()[twins]).all() else None


def _bent(points, corner, facet, twins):
    """Whether (3T,) the mesh is bent inwards at half-edges: the triangle beyond rises over the plane of this one."""
    a, b, c = v = points.take(corner, 1).swapaxes(0, 1)
    across = cross(b - a, c - a)
    squared = dot(across, across)
    extent = np.linalg.norm(np.ptp(v, axis=(0, 2)))
    beyond = corner.T.ravel()[_opposite(twins)].reshape(-1, 3)
    bent = np.empty(beyond.shape, bool)
    for k in range(3):
        edge = v[AFTER[k]] - v[k]
        rise = dot(facet, points.take(beyond[:, k], 1) - v[k])
        altitude = squared[twins[k::3] // 3] / np.maximum(dot(edge, edge), _TINY)  # squared
        bent[:, k] = rise > (_BENT / extent) * altitude
    bent = bent.ravel()
    return bent | bent[twins]


def _shut(points, corner, facet, one, other):
    """Corners (3,T) and unit normals (3,T) with the edges of pairs of half-edges (n,) replaced by the other
    diagonals."""
    index = corner.T.ravel()
    a, b, c, d = index[one], index[other], index[_opposite(one)], index[_opposite(other)]
    shut, facet = corner.copy(), facet.copy()
    for h, triangle in ((one, (c, a, d)), (other, (d, b, c))):
        shut[:, h // 3] = triangle
        p, q, r = points.take(np.stack(triangle), 1).swapaxes(0, 1)
        across = cross(q - p, r - p)
        across /= np.sqrt(np.maximum(dot(across, across), _TINY))
        facet[:, h // 3] = np.where(dot(across, facet.take(h // 3, 1)) < 0, -across, across)
    return shut, facet


def _opposite(halfedge):
    """Where, among all corners, the one opposite of half-edges is."""
    return halfedge - halfedge % 3 + BEFORE[halfedge % 3]
