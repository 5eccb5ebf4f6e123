"""Where refracted or reflected rays land: which receiver they meet first, and at which texel coordinates.

A ray is cast in float32; where it lands is computed in float64, through each receiver triangle's affine map from the
world to texel coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from ..optics import dot
from ..rays import MISS
from .carried import Rows
from .meetings import HISTORIES, once
from .photons import bend, bounce
from .silhouettes import lines

MISSED, OCCLUDED, SHADOWED, UNLIT, SHADED, TRAPPED, BACK = -1, -2, -3, -4, -5, -6, -7
CULLED, BEYOND, OTHER, FAINT = -8, -9, -10, -11
LOST = {
    MISSED: "missed",
    OCCLUDED: "occluded",
    SHADOWED: "shadowed",
    SHADED: "shadowed_by_water",
    TRAPPED: "trapped",
    BACK: "back",
    CULLED: "culled",
    BEYOND: "beyond_bounces",
    FAINT: "faint",
}
DARK = SHADOWED, SHADED  # no light comes to the water
SPREAD = 16.0  # area on the receiver per area of the beam, at most: light along a wall has no limit


@dataclass
class Nodes:
    """Points of the water and where their rays land: m, n (3,k) position and normal, interpolated, not unit; chart
    (k,) by number, or MISSED, OCCLUDED, SHADOWED, UNLIT off a sharp cone, BACK of a receiver's triangle, CULLED by a
    volume, BEYOND the last meeting that counts, FAINT, or OTHER where the light is not this lander's; x, y (k,) texel
    coordinates; spread (k,) length on the receiver per length of the beam, at most; carried (R,k) by the lander's
    `rows`."""

    m: np.ndarray
    n: np.ndarray
    chart: np.ndarray
    x: np.ndarray
    y: np.ndarray
    spread: np.ndarray
    carried: np.ndarray

    def take(self, index):
        if isinstance(index, slice):
            return Nodes(*(a[..., index] for a in vars(self).values()))
        return Nodes(*(np.take(a, index, axis=-1) for a in vars(self).values()))

    def where(self, chosen, other):
        """These, but `other` where chosen (k,)."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Nodes(*(np.where(chosen, theirs, ours) for ours, theirs in pairs))

    def join(self, other):
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Nodes(*(np.concatenate(pair, axis=-1) for pair in pairs))


class Lander:
    """Refracts rays at points of the water, or reflects them, and finds where they land; what lies between two rays is
    not `certain`.

    receivers of a Scene and their Texels; tracer: a Tracer over the receivers, in their order, and all that occludes;
    source: see `sources.py`; eta and sigma_a (3,) of the water; mirrored: reflect, do not refract; fresnel: refract by
    it. Charts are numbered through all receivers; image (charts,) is the receiver that each belongs to. rows: what rays
    carry; hides: light that lands may lie between rays that do not, however close they are where they start; grazing:
    light is known to fall or rise steeply towards its borders; fine: how much smaller than usual parts get before
    points speak for them.
    """

    certain, hides, grazing, fine = False, False, False, 1.0

    def __init__(
        self, receivers, texels, tracer, outlines, meetings, source, eta, sigma_a, mirrored=False, fresnel=True
    ):
        maps = [texel_maps(r, t.resolution) for r, t in zip(receivers, texels, strict=True)]
        self._maps = np.ascontiguousarray(np.concatenate([np.zeros((0, 3, 4)), *maps]).reshape(-1, 12).T)
        counts = [t.chart.max(initial=-1) + 1 for t in texels]
        bases = np.cumsum([0, *counts])
        self._charts = np.concatenate([np.zeros(0, np.int64), *(t.chart + b for t, b in zip(texels, bases))])
        self._count = bases[-1]
        self.image = np.tile(np.repeat(np.arange(len(texels)), counts), 1 if meetings is None else HISTORIES)
        self._tracer, self._outlines, self._source, self._eta = tracer, outlines, source, eta
        self.rows = Rows(sigma_a, source, again=meetings is not None)
        self._meetings, self._enters, self.again = meetings, not mirrored, 0
        self._turn, self._keep = (bounce, 1.0) if mirrored else (partial(bend, fresnel=fresnel), 1 / eta)
        self._side = max((t.resolution for t in texels), default=0)

    def clear(self, m, n, triangles, shadowed):
        """Whether (T,) nothing can hide between the rays at the corners of triangles (T,3) of points m (3,k) with
        normals n (3,k), nor between these and the light where shadowed (T,) bool."""
        towards = np.broadcast_to(self._source.incident(m)[0], m.shape)
        near = self._outlines.near(m, self._rays(n, towards)[0], triangles)
        at = np.flatnonzero(shadowed)
        near[at] += self._outlines.near(m, towards, triangles[at])
        return lines(near)

    def weight(self, _chart, _x, _y):
        """How much more error (k,) is let pass than elsewhere, of beams whose six rays land at charts, x, y (6,k): None
        where it is all alike."""
        return None

    def _rays(self, n, towards):
        """Unit directions (3,k) of rays of the light that is `towards` the water, from where its normals are n (3,k),
        and the share (k,) of light in each."""
        g, share = self._turn(dot(towards, n), dot(n, n), self._eta)
        direction = n * g - towards * self._keep
        return direction, share if self._enters else np.where(self._meetings.sinks(direction), 0.0, share)

    def land(self, m, n, shadowed):
        """Nodes of points m (3,k) with normals n (3,k), in the world; shadowed (k,) bool: look for a shadow there."""
        towards, distance, met = self._source.incident(m)
        direction, share = self._rays(n, towards)
        if self._meetings is None:
            rays = once(m, direction, self._enters)
        else:
            rays = self._meetings.follow(m, direction, self._enters)
            self.again += np.count_nonzero(rays.history)
        start, direction = rays.origin, rays.direction
        hit = self._tracer.first(start.T, direction.T)
        on_receiver = (hit != MISS) & (hit < len(self._charts))
        # Where nothing passes, at the back of normals, is a border.
        chart = np.where((hit == MISS) | (share == 0), MISSED, OCCLUDED)
        triangle = np.where(on_receiver, hit, 0)
        x = y = tau = np.zeros(len(chart))
        spread = np.ones(len(chart))
        if len(self._charts):
            with np.errstate(divide="ignore", invalid="ignore"):  # a surface exactly along the ray, or none
                fall = self._along(0, triangle, direction, 0)
                tau = -self._along(0, triangle, start, 1) / fall
                point = start + tau * direction
                x, y = self._along(1, triangle, point, 1), self._along(2, triangle, point, 1)
            on_receiver &= np.isfinite(x) & np.isfinite(y) & (share > 0)
            x, y = np.clip(x, 0, self._side), np.clip(y, 0, self._side)
            front = np.where(fall < 0, np.take(self._charts, triangle) + rays.history * self._count, BACK)
            chart = np.where(on_receiver, front, chart)
            spread = np.where(on_receiver, 1 / np.maximum(np.abs(fall), 1 / SPREAD), 1.0)
        carried = self.rows.of(met, share, rays.wet + tau * rays.inside, on_receiver, rays.share)
        if self._meetings is not None:
            chart[rays.trapped] = TRAPPED
            chart[self._meetings.shaded(m, towards, distance)] = SHADED
        chart[self._in_shadow(m, towards, distance, shadowed)] = SHADOWED
        if self._source.varies:
            spread *= self._source.growth(distance, np.where(on_receiver, tau, 0.0) * self._keep)
            if self._source.sharp:
                chart[met == 0] = UNLIT
        return Nodes(m, n, chart, x, y, spread, carried)

    def _in_shadow(self, m, towards, distance, shadowed):
        """Indices of the points m (3,k) that something stands before, of those to be looked at, shadowed (k,)."""
        looked = np.flatnonzero(shadowed)
        towards, distance = np.broadcast_to(towards, m.shape)[:, looked], np.broadcast_to(distance, len(shadowed))
        return looked[self._tracer.blocked(m[:, looked].T, towards.T, distance[looked])]

    def _along(self, row, triangle, vectors, homogeneous):
        maps = self._maps[4 * row : 4 * row + 4]
        value = np.take(maps[0], triangle) * vectors[0]
        value += np.take(maps[1], triangle) * vectors[1]
        value += np.take(maps[2], triangle) * vectors[2]
        return value + np.take(maps[3], triangle) if homogeneous else value


def texel_maps(receiver, resolution):
    """Affine maps (T, 3, 4) of a receiver's triangles: rows give the height above its plane [m] and the texel
    coordinates x, y of a world point (p, 1). Triangles without area get a height that no ray meets."""
    v = receiver.positions[receiver.triangles]
    e1, e2 = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    normal = np.cross(e1, e2)
    squared = (normal**2).sum(1)
    sound = squared > 0
    inverse = np.where(sound, 1 / np.where(sound, squared, 1), 0)[:, None]
    dual1, dual2 = np.cross(e2, normal) * inverse, np.cross(normal, e1) * inverse
    uv = receiver.uvs * resolution
    u1, u2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    rows = np.empty((len(v), 3, 4))
    rows[:, 0, :3] = normal * np.sqrt(inverse)
    for k in range(2):
        rows[:, 1 + k, :3] = u1[:, k : k + 1] * dual1 + u2[:, k : k + 1] * dual2
    rows[:, :, 3] = -(rows[:, :, :3] * v[:, 0, None]).sum(2)
    rows[:, 1:, 3] += uv[:, 0]
    return rows
