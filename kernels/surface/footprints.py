"""What the light through small triangles of the water does on the receivers, told from slopes alone.

Light that meets slopes s goes q(s) across for each metre down (Snell). Of a triangle at depth D over texels of width
t the corners land at (p + D q(s)) / t, in texels: that is its image, and its area tells how dense the light is there.
All depths and texel sizes of the receivers are paired with all triangles, as if by chance. So one knows, before any
light is followed, what an error of the slopes will cost - on this water, at this depth, on these texels.

Errors are mean squared, over the squared mean of the light.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..dispersion import etas
from ..optics import cosine_refracted
from ..scene import Sun

_TEXELS = 1 << 12  # that depths and widths are taken from, at most, of those of so many times as many that lie below
_FINER = 4
_GOLDEN = (np.sqrt(5) - 1) / 2
# Images no thinner than this part of their length, or of its square below a texel, are as dense as folds are on texels:
# measured, with _SHARES, on 30 waters of tests/bench/estimate_ponds.py.
_THIN = 0.2
_THIN_ERROR = 0.1
_OWN = 1.65  # of what is predicted of a mesh's own error from its worst part: 1.0 to 2.5 was seen
# What of the error of a triangle's evened slopes shows on texels, by the triangle's length in texels: those of a
# texel's size lose nearly all of it in the mean over the texel, unless it moves light by a good part of a texel.
_LENGTHS = np.array([0.4, 0.75, 1.1, 1.5, 2.0, 3.0, 4.0, 6.0])
_SHARES = np.array([3.0, 1.1, 0.4, 0.15, 0.2, 0.8, 1.2, 2.0])
_BENT = 3.0  # a texel
# Measured on eleven of those waters with discs of 0.1 to 0.9 texels.
_SMOOTH, _FOLDED, _ROUND_FOLDS = 0.02, 0.14, 5.0
_SLOPE = 0.2  # of waves, for how far they part colours: rather too much
_TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class Triangles:
    """Some of the water: plan (2,3,n) [m] of corners; slopes (2,3,n) there, as true as they are known; middles (2,3,n),
    slopes in the middles of the edges from the corners; own (2,3,n), what the mesh's normals say of the corners; share:
    what the squared deviation of all the mesh is of theirs."""

    plan: np.ndarray
    slopes: np.ndarray
    middles: np.ndarray
    own: np.ndarray
    share: float = 1.0


class Footprints:
    """How light lands under a Scene's water: depth (m,) [m] and width (m,) [m] of some texels, and lights by their
    share of the light. through: below the water; else they take what is mirrored."""

    def __init__(self, depth, width, lights, level, eta, through):
        self._depth, self._width, self._lights = depth, width, lights
        self._level, self._eta, self._through = level, eta, through
        self._last = None, ()

    @classmethod
    def of(cls, scene, texels):
        """The Footprints of a Scene on Texels; None without texels or lights."""
        level = float(scene.water.positions[:, 2].mean()) if len(scene.water.positions) else 0.0
        some = slice(None, None, sum(len(t.texel) for t in texels) // (_FINER * _TEXELS) | 1)
        depth = np.concatenate([np.zeros(0), *(level - t.positions[some, 2] for t in texels)])
        area = np.concatenate([np.zeros(0), *(t.area[some] for t in texels)])
        below = np.flatnonzero(depth > 0)
        through = len(below) > 0
        at = below if through else np.arange(len(depth))
        at = at[:: len(at) // _TEXELS | 1]
        at = at[area[at] > 0]
        power = [
            float(np.mean(light.irradiance if isinstance(light, Sun) else light.intensity)) for light in scene.lights
        ]
        lights = [(light, p / sum(power)) for light, p in zip(scene.lights, power, strict=True) if p > 0]
        if not len(at) or not lights:
            return None
        return cls(np.abs(depth[at]), np.sqrt(area[at]), lights, level, scene.eta, through)

    def tessellated(self, triangles, parts):
        """Errors (k,) that Triangles leave whose slopes are known at the corners of their k x k parts, for each of
        parts, and straight between."""
        between = _halfway(triangles.slopes)
        errors = np.zeros(len(parts))
        for images, share in self._images(triangles):
            bent = images.ways(triangles.middles) - images.ways(between)
            bent = np.sqrt((bent**2).sum(0)).max(0)
            errors += share**2 * np.array([images.spread(bent, k) for k in parts])
        return errors

    def own(self, triangles):
        """Error that Triangles leave which keep the normals of their mesh."""
        error = 0.0
        for images, share in self._images(triangles):
            error += share**2 * images.apart(images.moved(triangles.own))
        middles = _halfway(triangles.own) + triangles.middles - _halfway(triangles.slopes)
        mesh = Triangles(triangles.plan, triangles.own, middles, triangles.own)
        return _OWN * triangles.share * (error + float(self.tessellated(mesh, (1,))[0]))

    def power(self, triangles):
        """Mean square of the light over its squared mean, rather too low than too high."""
        shares = [(share, images.power(_THIN)) for images, share in self._images(triangles)]
        return 1 + sum(share**2 * max(power - 1, 0.0) for share, power in shares)

    def disc(self, triangles):
        """What share of the light's variance the widest sun's disc blurs: an ellipse of half axes of R texels blurs
        _SMOOTH R^4 of light without folds, and _FOLDED R^2 of that on folds."""
        worst = 0.0
        for light, (images, _) in zip(self._lights, self._images(triangles), strict=True):
            squared = float((self._half_axis(light[0], self._depth / self._width) ** 2).mean())
            folded = min(_ROUND_FOLDS * images.folded(), 1.0)
            worst = max(worst, (1 - folded) * min(_SMOOTH * squared, _FOLDED) * squared + folded * _FOLDED * squared)
        return min(worst, 1.0)

    def _half_axis(self, light, depth):
        """Half axis (n,) [texel] of the ellipse that a light's disc is at depths (n,) [texel]."""
        return getattr(light, "angle", 0.0) / 2 * (1 / self._eta if self._through else 1.0) * depth

    def parted(self, abbe):
        """How far [texel] red lands from blue in water of that Abbe number, root mean square."""
        plan, none = np.zeros((2, 1, 1)), np.zeros((2, 1, 1))
        ends = etas(self._eta, abbe)[[0, 2]]
        apart = 0.0
        for light, _ in self._lights:
            red, blue = (_Way(light, plan, self._level, eta, self._through).across(none) for eta in ends)
            apart = max(apart, float(np.abs(red - blue).max()))
        waves = abs(1 / ends[0] - 1 / ends[1])  # for slopes of 1
        return (apart + _SLOPE * waves) * float(np.sqrt(((self._depth / self._width) ** 2).mean()))

    def _images(self, triangles):
        """Pairs of the Images of Triangles under a light and its share; those asked for last are kept."""
        if self._last[0] is not triangles:
            self._last = triangles, list(self._imaged(triangles.plan, triangles.slopes))
        return self._last[1]

    def _imaged(self, plan, slopes):
        pick = (np.arange(plan.shape[2]) * _GOLDEN % 1 * len(self._depth)).astype(np.int64)
        depth, width = self._depth[pick], self._width[pick]
        for light, share in self._lights:
            way = _Way(light, plan, self._level, self._eta, self._through)
            blur = np.sqrt(1 + 3 * self._half_axis(light, depth / width) ** 2)
            yield _Images(way, plan / width, depth / width, slopes, blur), share


def _halfway(slopes):
    return (slopes + np.roll(slopes, -1, axis=1)) / 2


class _Way:
    """Where light goes that meets the water at plan (2,3,n): for each metre of depth, at given slopes."""

    def __init__(self, light, plan, level, eta, through):
        self._eta, self._through = eta, through
        if isinstance(light, Sun):
            self._d = np.asarray(light.direction, float).reshape(3, 1, 1)
        else:
            ray = np.stack([*plan, np.full(plan.shape[1:], level)]) - np.asarray(light.position, float).reshape(3, 1, 1)
            self._d = ray / np.maximum(np.sqrt((ray**2).sum(0)), _TINY)

    def across(self, slopes):
        """(2,3,n) of slopes (2,3,n)."""
        n = np.stack([-slopes[0], -slopes[1], np.ones(slopes.shape[1:])])
        n /= np.sqrt((n * n).sum(0))
        cos_i = np.maximum(-(self._d * n).sum(0), 0.0)
        if self._through:
            t = self._d / self._eta + (cos_i / self._eta - cosine_refracted(cos_i, self._eta)) * n
        else:
            t = self._d + 2 * cos_i * n
        return t[:2] / np.maximum(np.abs(t[2]), 1e-3)


class _Images:
    """Images of triangles: plan (2,3,n) and depth (n,) in texels, slopes (2,3,n); blur (n,): width in texels of a box
    with the variance of a texel and of the light's disc."""

    def __init__(self, way, plan, depth, slopes, blur):
        self._way, self._plan, self._depth, self._blur = way, plan, depth, blur
        self._corners = self.moved(slopes)
        self._area = _area(self._corners)
        self._area *= -1.0 if self._area.sum() < 0 else 1.0
        self._flux = np.abs(_area(self.moved(np.zeros_like(slopes))))  # still water's light is 1 on a texel
        self._long = _long(self._corners)
        self._all = max(float(self._flux.sum()), _TINY)

    def ways(self, slopes):
        """How far (2,3,n) [texel] light goes across that meets slopes (2,3,n)."""
        return self._depth * self._way.across(slopes)

    def moved(self, slopes):
        """Where (2,3,n) the corners land with slopes (2,3,n)."""
        return self._plan + self.ways(slopes)

    def spread(self, bent, parts):
        """Error of spreading light evenly over k x k parts of images which are bent by `bent` (n,), see
        `splat/prediction.py`."""
        bent, size = bent / parts**2, np.maximum(self._long, _TINY) / parts
        long = np.maximum(size, self._blur)
        wide = np.maximum(2 * np.abs(self._area) / (size * parts**2), self._blur)
        moved = self._flux / parts**2 * np.minimum(bent, wide)
        shows = np.exp(np.interp(np.log(size / self._blur), np.log(_LENGTHS), np.log(_SHARES)))
        shows = np.maximum(shows, np.minimum(_BENT * bent / self._blur, 1.0))
        return float((shows * moved**2 / (long * wide**3)).sum() * parts**2 / self._all)

    def apart(self, corners):
        """Mean squared difference of this light from that of other corners (2,3,n)."""
        other = _area(corners)
        other *= -1.0 if other.sum() < 0 else 1.0
        area, density = self._density(np.abs(self._area), _THIN_ERROR)
        return float((area * (density - self._density(np.abs(other), _THIN_ERROR)[1]) ** 2).sum() / self._all)

    def folded(self):
        """Share of the light in images that are turned over, or as thin as those on folds."""
        thin = self._area < _THIN * np.minimum(self._long, self._long**2) / 2
        return float(self._flux[thin].sum() / self._all)

    def power(self, thin):
        """Mean square of the light, where still water's is 1."""
        return float((self._flux * self._density(np.abs(self._area), thin)[1]).sum() / self._all)

    def _density(self, area, thin):
        area = np.maximum(area, np.maximum(thin * np.minimum(self._long, self._long**2), _TINY))
        return area, self._flux / area


def _area(corners):
    """Signed areas (n,) of triangles (2,3,n)."""
    (x1, y1), (x2, y2) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (x1 * y2 - y1 * x2) / 2


def _long(corners):
    """Longest edges (n,) of triangles (2,3,n)."""
    return np.sqrt(((corners - np.roll(corners, -1, axis=1)) ** 2).sum(0).max(0))
