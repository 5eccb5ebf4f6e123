"""The smooth water that a mesh samples, as a finer mesh whose positions and normals are that water's.

On every sheet of the water that is a height field, over the plan or over an upright plane, a B-spline is fitted to the
vertices; folds and overhangs between the sheets follow cubics between normals that relations along the edges give
(`splines.py`). Each triangle is cut in k x k parts whose vertices take their places and normals from these; elsewhere -
on droplets, creases, and folds that the mesh does not resolve - the mesh keeps its shape. An edge's shape depends on
its ends alone, so nothing opens anywhere. Over the plan nothing moves but up and down: outline, holes and areas are the
mesh's.

k follows from how far the slopes depart from what the corners interpolate, and from what that does to the light on the
texels (`footprints.py`); where the water is no height field, from how many texels it moves the light.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .deviation import own_deviation, rms, some_edges
from .evening import evened
from .footprints import Footprints
from .scaffold import Scaffold
from .smoothing import Smoothing
from .splines import Splines, settled
from .tessellate import Tessellation
from .window import look

# The relative mean squared error over the squared deviation of the light in texels, the most seen on regular, jittered,
# blue-noise and iso-surface meshes of five waters: of interpolation between evened slopes, and of a mesh's own.
_INTERPOLATED, _OWN = 1.2, 15.0
_HALVED = 0.4  # texels, half axis of a sun's disc that leaves half of that error: measured on the pool and four waters
_FEW = 2  # parts that mostly do: the errors of more are not asked for at once
_SAMPLED = 2048  # triangles that errors are predicted from
# A prediction is off by so much now and then; that of one part a triangle is not: the truth was 0.01 to 0.82 of it on
# 24 waters of tests/bench/accuracy_ponds.py and estimate_ponds.py.
_MARGIN, _MARGIN_OF_ONE = 1.6, 1.0
_MOST_PARTS, _MOST_TRIANGLES = 16, 4_000_000
_AS_IT_IS = "the mesh as it is, "


@dataclass(frozen=True)
class Need:
    """What the water has to be good for. reach: texels that light moves by for a slope that is off by 1, fewer where a
    lamp's disc blurs that; tolerance: the mean squared error that is good enough, over the mean square of the light
    where footprints tell of that, and over its squared mean where not."""

    reach: float
    tolerance: float
    footprints: Footprints | None = None

    @classmethod
    def of(cls, scene, texels, tolerance):
        """The Need of the Texels of a Scene's receivers, by depth below the middle of the water and by texel size."""
        level = (scene.water.positions[:, 2].max() + scene.water.positions[:, 2].min()) / 2
        reach = 0.0
        for own in texels:
            if len(own.texel):
                depth = level - own.positions[:, 2]
                moved = np.where(depth > 0, 1 - 1 / scene.eta, 2.0) * depth  # refracted; reflected
                reach = max(reach, float(np.sqrt((moved**2).mean() / own.area.mean())))
        angle = min((getattr(light, "angle", 0.0) for light in scene.lights), default=0.0)
        disc = reach * angle / 2 / (scene.eta - 1)  # half axis [texel]
        return cls(reach / np.hypot(1, disc / _HALVED), tolerance, Footprints.of(scene, texels))


def margin(parts):
    """How much more than is predicted the light may err of which each triangle has `parts` x `parts` parts."""
    return _MARGIN_OF_ONE if parts == 1 else _MARGIN


def prepared(water):
    """The Smoothing that a Water deserves; one still to be chosen, where it is not shaded smooth or has no sheet."""
    return settled(Smoothing(), water) if is_smooth(water) else Smoothing()


def is_smooth(water):
    """Whether a Water is shaded smooth all over, by normals that are not set by hand."""
    same = water.triangles is water.normal_triangles or np.array_equal(water.triangles, water.normal_triangles)
    return len(water.triangles) > 0 and same


class Reconstruction:
    """Reconstructs frame after frame, by the Smoothing of their sequence; keeps how triangles are cut while they stay
    the same, which saves time and changes nothing.

    error: the mean squared error over the squared mean of the light that the last Water's own triangles leave; 0 where
    they are what the artist wants. power: mean square of that light over its squared mean, as far as it was looked at.
    """

    def __init__(self, smoothing=None):
        self._known, self._smoothing, self._scaffold = None, smoothing or Smoothing(), Scaffold()
        self.error, self.power = 0.0, 1.0

    def apply(self, water, need):
        """(Water, sentence): the Water reconstructed for a Need, or as it is where that would gain nothing."""
        self.error, self.power = 0.0, 1.0
        if not is_smooth(water):
            return water, _AS_IT_IS + "since its normals are flat or set by hand"
        edges = some_edges(water.triangles)
        own = rms(*own_deviation(water, edges)) * need.reach
        self.error = _OWN * own**2
        if self.error <= need.tolerance:
            seen = look(water, self._smoothing) if need.footprints else None
            if seen is not None:
                self.error = need.footprints.own(seen)
            return water, _AS_IT_IS + "which is fine enough"
        splines = Splines(water, self._smoothing, need.tolerance, self._scaffold)
        level, upright, between = splines.count(water.triangles)
        if not level + upright:
            return water, _AS_IT_IS + "since it is nowhere a wide and smooth height field"
        parts = self._parts(water, splines, edges, need)
        finer = self._refined(water, splines, self._tessellation(water, splines.cut, parts))
        of = f"{level} of {len(water.triangles)} triangles" + (f", upright ones for {upright}" if upright else "")
        of += f", cubics between their normals for {between}" if between else ""
        return (
            finer,
            f"B-splines over the plan, lambda = {splines.smoothing.value:g}, for {of}, in {parts} x {parts} parts",
        )

    def _parts(self, water, splines, edges, need):
        """k, and what error it leaves; by deviations it falls as their square, and they as k^-2."""
        most = int(max(1, min(_MOST_PARTS, np.sqrt(_MOST_TRIANGLES / len(water.triangles)))))
        some = splines.some(water, _SAMPLED) if need.footprints else None
        if some is None:
            deviation = rms(*splines.deviation(edges)) * need.reach
            parts = int(np.clip(np.ceil((deviation**2 * _INTERPOLATED / need.tolerance) ** 0.25), 1, most))
            self.error = _INTERPOLATED * deviation**2 / parts**4
            return parts
        self.power = need.footprints.power(some)
        for parts in (range(1, min(_FEW, most) + 1), range(_FEW + 1, most + 1)):
            for k, error in zip(parts, need.footprints.tessellated(some, parts), strict=True):
                self.error = float(error)
                if margin(k) * error <= need.tolerance * self.power:
                    return k
        return most

    def _tessellation(self, water, cut, parts):
        """The Tessellation of the frame before, where that is of the same triangles, or a new one."""
        if self._known is not None:
            triangles, before, known = self._known
            same = triangles is water.triangles or np.array_equal(triangles, water.triangles)
            if same and known.k == parts and np.array_equal(before, cut):
                return known
        known = Tessellation(water.triangles, water.twins, len(water.positions), cut, parts)
        self._known = water.triangles, cut, known
        return known

    @staticmethod
    def _refined(water, splines, tessellation):
        """The Water of all vertices that a Tessellation asks for."""
        along, inside = tessellation.shares()
        groups = (tessellation.ends, along), (tessellation.inner, inside)
        edges, inner = (splines.between(*group) for group in groups)
        positions, normals = (
            np.concatenate([corners, *(points[k].reshape(3, -1) for points in (edges, inner))], 1)
            for k, corners in enumerate((splines.positions, splines.normals))
        )
        normals = evened(normals, _bends(splines, tessellation, edges[1]), tessellation)
        triangles = tessellation.triangles
        return replace(
            water,
            positions=np.ascontiguousarray(positions.T),
            normals=np.ascontiguousarray(normals.T),
            triangles=triangles,
            normal_triangles=triangles,
            twins=tessellation.twins,
        )


def _bends(splines, tessellation, along):
    """By how much (3,E) the normals in the middles of a Tessellation's edges depart from the mean of those at their
    ends, as far as parabolas tell from normals `along` (3, E, k - 1) them."""
    k, ends = tessellation.k, np.take(splines.normals, tessellation.ends, axis=1)
    if k == 1:
        along, part = splines.between(tessellation.ends, np.full((2, 1), 0.5))[1], 0.5
    else:
        part = (k // 2) / k
    off = along[..., k // 2 - (k > 1)] - (1 - part) * ends[:, 0] - part * ends[:, 1]
    return off / (4 * part * (1 - part))
