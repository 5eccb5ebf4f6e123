"""Receivers that glass stands on: its faces lie in theirs, and light that leaves the ones starts beyond the others.

They are moved back a hair, and made wider by as much, so that nothing passes beside them where they meet others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..casters import Glass
from ..facets import used
from ..halfedges import build_twins
from ..rays import MISS, Tracer, soup

_BACK = 2.0  # of how far off a surface rays start: how far back
_SIGHT = 4.0  # of that: from how far within a face is looked out for a receiver
_LOOK = np.array([[1, 1, 1], [8, 1, 1], [1, 8, 1], [1, 1, 8]]) / [[3], [10], [10], [10]]  # where on a triangle
_ENDS = "min", "max"
_LEAST = 0.2  # cosine between a corner and its faces: sharper ones are not moved as far as their faces ask
_TINY = np.finfo(float).tiny


def receded(scene, off):
    """The receivers (a tuple) of a Scene, moved back where a face of glass or of a body of water lies in them, for rays
    that start `off` [m] from what they leave."""
    glass = [caster for caster in scene.casters if isinstance(caster.material, Glass)]
    if (scene.water.twins >= 0).all():
        glass.append(scene.water)  # a body of water, no surface that ends at walls
    found = set()
    if off > 0:
        found |= {k for _, k in _facing(glass, scene.receivers, off)} | {
            k for k, _ in _facing(scene.receivers, glass, off)
        }
    return tuple(_moved(r, _BACK * off) if k in found else r for k, r in enumerate(scene.receivers))


def _facing(ones, others, off):
    """Pairs of numbers of meshes, of which faces of the one lie in faces of the other and look the other way, as seen
    from a few points of each triangle of the ones."""
    ones = [(k, mesh) for k, mesh in enumerate(ones) if len(mesh.triangles)]
    others = [(k, mesh) for k, mesh in enumerate(others) if len(mesh.triangles)]
    if not ones or not others:
        return set()
    low, high = (np.array([getattr(used(m.positions, m.triangles), end)(0) for _, m in others]) for end in _ENDS)
    points, outward, own = [np.zeros((0, 3))], [np.zeros((0, 3))], [np.zeros(0, np.int64)]
    for k, mesh in ones:
        v = mesh.positions[mesh.triangles]
        least, most = v.min(1) - off, v.max(1) + off
        beside = ((low <= most.max(0)) & (high >= least.min(0))).all(1)
        if beside.any():
            near = ((least <= high[beside].max(0)) & (most >= low[beside].min(0))).all(1)
            points.append((_LOOK @ v[near]).reshape(-1, 3))
            outward.append(np.repeat(_outward(mesh)[near], len(_LOOK), 0))
            own.append(np.full(len(points[-1]), k))
    points, outward, own = map(np.concatenate, (points, outward, own))
    positions, triangles = soup(mesh for _, mesh in others)
    end = Tracer(positions, triangles).first(points - _SIGHT * off * outward, outward)
    front, first = np.concatenate([_outward(mesh) for _, mesh in others])[end], positions[triangles[end, 0]]
    lies = (end != MISS) & (np.abs(((points - first) * front).sum(1)) <= off) & ((front * outward).sum(1) < 0)
    other = np.repeat([k for k, _ in others], [len(mesh.triangles) for _, mesh in others])[end]
    return set(zip(own[lies].tolist(), other[lies].tolist(), strict=True))


def _outward(mesh):
    """Unit normals (T,3) of triangles, on the side that they look to."""
    v = mesh.positions[mesh.triangles]
    across = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    if hasattr(mesh, "normals"):
        across *= np.where((across * mesh.normals[mesh.normal_triangles].sum(1)).sum(1) < 0, -1, 1)[:, None]
    return across / np.sqrt(np.maximum((across**2).sum(1, keepdims=True), _TINY))


def _moved(receiver, by):
    """A Receiver whose triangles lie `by` [m] or a little more behind where they were; its rims are moved outwards."""
    corner, across = receiver.triangles, _outward(receiver)
    back, facing = _mean(corner.ravel(), np.repeat(across, 3, 0), len(receiver.positions))
    rim = np.flatnonzero(build_twins(corner) < 0)
    start, stop = corner.ravel()[rim], corner.ravel()[rim - rim % 3 + (rim + 1) % 3]
    out = np.cross(receiver.positions[stop] - receiver.positions[start], across[rim // 3])
    out /= np.sqrt(np.maximum((out**2).sum(1, keepdims=True), _TINY))
    wider, beside = _mean(np.concatenate([start, stop]), np.concatenate([out, out]), len(receiver.positions))
    return replace(receiver, positions=receiver.positions + by * (wider / beside - back / facing))


def _mean(corner, vectors, count):
    """Unit means (count,3) of unit vectors (n,3) at corners (n,), 0 where there are none, and the least cosines
    (count,1) with them."""
    mean = np.stack([np.bincount(corner, vectors[:, k], count) for k in range(3)], 1).astype(float)
    mean /= np.sqrt(np.maximum((mean**2).sum(1, keepdims=True), _TINY))
    least = np.ones(count)
    np.minimum.at(least, corner, (mean[corner] * vectors).sum(1))
    return mean, np.maximum(least, _LEAST)[:, None]
