"""Water as solvers may trust it: numbers that are numbers, every normal a direction, no triangle twice. And the normals
of what else bends light.

What simulations, modifiers and caches hand over is not always so. What can be mended is mended, and said.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .halfedges import build_twins


def sound_water(water):
    """The Water with its normals and triangles mended, and sentences (a list of str) on what that changed.

    Normals that are zero or no numbers become those of the facets round them; of triangles with the same corners one
    stays. Raises ValueError for positions that are not finite.
    """
    finite = np.isfinite(water.positions)
    if not finite.all():
        broken = np.count_nonzero(~finite.all(1))
        raise ValueError(f"positions must be finite, but {broken} of {len(water.positions)} are not")
    sentences = []
    repeats = _repeats(water)
    if len(repeats):
        sentences.append(f"{len(repeats)} triangles that are in the water already: each counts once")
    spurious = np.concatenate([repeats, _pointless(water)])
    if len(spurious):
        water = _without(water, spurious)
    water, said = sound_normals(water, "the water")
    sentences += said
    edges = _turns(water)
    if edges:
        sentences.append(
            f"light on parts of the water that are wound against their neighbours, along {edges} edges: facets that "
            "face away from the sun take none"
        )
    return water, sentences


def sound_normals(mesh, of):
    """The Water or Caster with normals of the facets round them in place of those that are zero or no numbers, and a
    sentence on that (a list of one str, or none)."""
    with np.errstate(over="ignore"):
        squared = np.einsum("nk,nk->n", mesh.normals, mesh.normals)
    without = np.flatnonzero(~((squared > np.finfo(float).tiny) & (squared < np.inf)))
    without = without[np.isin(without, mesh.normal_triangles)] if len(without) else without
    if not len(without):
        return mesh, []
    sentence = f"{len(without)} normals of {of} that are zero or no numbers: the facets' stand in"
    return replace(mesh, normals=_with_facets_normals(mesh, without)), [sentence]


def _without(water, spurious):
    """The Water without some of its triangles."""
    triangles, shading = (np.delete(a, spurious, axis=0) for a in (water.triangles, water.normal_triangles))
    shading = triangles if np.array_equal(triangles, shading) else shading
    return replace(water, triangles=triangles, normal_triangles=shading, twins=build_twins(triangles))


def _pointless(water):
    """Triangles that have a corner twice: they only stand between their neighbours."""
    a, b, c = water.triangles.T
    return np.flatnonzero((a == b) | (b == c) | (c == a))


def _repeats(water):
    """Triangles that have the same corners as one before them."""
    if not len(water.triangles):
        return np.zeros(0, np.int64)
    # The edges of repeated triangles have no twin, or one in the other copy: few other triangles are so.
    a, b, c = (np.where(twins < 0, -1, twins // 3) for twins in water.twins.reshape(-1, 3).T)
    highest = np.maximum(np.maximum(a, b), c)
    alone = np.flatnonzero(np.logical_and.reduce([(across == highest) | (across < 0) for across in (a, b, c)]))
    rows = np.sort(water.triangles[alone], axis=1)
    _, first = np.unique(rows, axis=0, return_index=True)
    return np.setdiff1d(alone, alone[first])


def _facets(water, chosen):
    """Normals (n,3) of triangles `chosen`, twice their area long, by their winding."""
    v = water.positions[water.triangles[chosen]]
    return np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])


def _with_facets_normals(water, without):
    """The normals (N,3); those `without` get the mean of the facets round them, on the side of their neighbours."""
    normals = np.nan_to_num(water.normals, nan=0.0, posinf=0.0, neginf=0.0)
    normals[without] = 0
    lacks = np.zeros(len(normals), bool)
    lacks[without] = True
    chosen = np.flatnonzero(lacks[water.normal_triangles].any(1))
    corners = water.normal_triangles[chosen]
    facets = _facets(water, chosen)
    facets *= np.where((facets * normals[corners].sum(1)).sum(1) < 0, -1.0, 1.0)[:, None]
    total = np.stack([np.bincount(corners.ravel(), np.repeat(f, 3), len(normals)) for f in facets.T], 1)[without]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normals[without] = np.where(length > 0, total / np.maximum(length, np.finfo(float).tiny), [0.0, 0.0, 1.0])
    return normals


def _turns(water):
    """How many edges lie between triangles that are wound against each other and whose normals follow the winding."""
    half = np.flatnonzero(water.twins > np.arange(len(water.twins)))
    other = water.twins[half]
    tails = water.triangles.ravel()
    against = np.take(tails, half) == np.take(tails, other)
    if not against.any():
        return 0
    follows = []
    for side in (half[against] // 3, other[against] // 3):
        shaded = water.normals[water.normal_triangles[side]].sum(1)
        follows.append((_facets(water, side) * shaded).sum(1))
    return int(np.count_nonzero(follows[0] * follows[1] > 0))
