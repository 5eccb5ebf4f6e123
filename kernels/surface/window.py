"""A first look at the water: the smooth surface of a small window of it, where its mesh is farthest off."""

from __future__ import annotations

import numpy as np

from .deviation import own_deviation, some_edges
from .fit import fit
from .footprints import Triangles
from .smoothing import LADDER

_VERTICES = 900  # in the window, about
_FEWEST = 100, 50  # vertices and triangles, at least
_RIM = 0.12  # of the window's side: what is left out along its border, where the spline is loose
_TOLERANCE = 1e-2, 1e-4  # of the fit: a look needs no more
_SOME = 512  # triangles
_GOLDEN = (np.sqrt(5) - 1) / 2
_UPRIGHT = 0.3  # least cosine between normals and the axis of heights


def look(water, smoothing):
    """Triangles in a window of a Water, None for water that is no height field; smoothing: a Smoothing, settled or
    not."""
    up = water.normals[:, 2]
    if not len(water.triangles) or np.abs(up).min() < _UPRIGHT or up.min() * up.max() < 0:
        return None
    plan = np.ascontiguousarray(water.positions[:, :2].T)
    low, high, share = _roughest(water, plan)
    points = water.positions[_within(plan, low, high)]
    rim = _RIM * (high - low)
    ids = np.flatnonzero(_within(plan, low + rim, high - rim)[water.triangles].all(1))
    if len(points) < _FEWEST[0] or len(ids) < _FEWEST[1]:
        return None
    distance = float(np.sqrt((high - low).prod() / len(points)))
    field = fit(points, distance, LADDER[-1] if smoothing.value is None else smoothing.value, _TOLERANCE)
    corner = water.triangles[ids].T
    at = plan[:, corner]
    between = (at + np.roll(at, -1, axis=1)) / 2
    true, middles = (field.at(*v.reshape(2, -1))[1:].reshape(v.shape) for v in (at, between))
    own = -water.normals[:, :2].T[:, corner] / up[corner]
    return Triangles(at, true, middles, own, share)


def glance(water):
    """Some Triangles of a Water whose normals all look up or all down, with the slopes of its own normals; None for
    other water."""
    some = np.arange(min(_SOME, len(water.triangles))) * _GOLDEN % 1 * len(water.triangles)
    corner = water.triangles[some.astype(np.int64)].T  # follows neither rows nor columns of a grid
    if not len(water.triangles) or np.abs(water.normals[corner, 2]).min() < _UPRIGHT:
        return None
    slopes = -np.moveaxis(water.normals[corner, :2], 2, 0) / water.normals[corner, 2]
    middles = (slopes + np.roll(slopes, -1, axis=1)) / 2
    return Triangles(np.moveaxis(water.positions[corner, :2], 2, 0), slopes, middles, slopes)


def _within(plan, low, high):
    return ((plan >= low[:, None]) & (plan <= high[:, None])).all(0)


def _roughest(water, plan):
    """The box, low and high (2,), of a grid over the plan (2,V) in which the mesh's slopes are farthest off, and what
    the mean of their squared deviations is of that there."""
    low, high = plan.min(1), plan.max(1)
    boxes = max(1, int(np.sqrt(plan.shape[1] / _VERTICES)))
    wide = np.maximum((high - low) / boxes, np.finfo(float).tiny)
    edges = some_edges(water.triangles)
    off, length = own_deviation(water, edges)
    column, row = np.clip((plan[:, edges[0]] - low[:, None]) / wide[:, None], 0, boxes - 1).astype(np.int64)
    box, area = row * boxes + column, length**2
    total = np.bincount(box, off**2 * area, boxes**2)
    mean = total / np.maximum(np.bincount(box, area, boxes**2), np.finfo(float).tiny)
    chosen = int(np.argmax(mean))
    start = low + wide * np.array([chosen % boxes, chosen // boxes])
    overall = total.sum() / max(area.sum(), np.finfo(float).tiny)
    return start, start + wide, float(overall / mean[chosen]) if mean[chosen] > 0 else 1.0
