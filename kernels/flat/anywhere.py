"""Still water over any receivers, with whatever stands in the way: one path to each texel's centre, and its legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..optics import dot
from ..rays import MISS, solid
from ..scene import Point, Sun
from ..solution import book
from .doubt import Border, Doubt, some
from .paths import paths
from .still import FINER

_BENDS = 24  # a step of 1 has two second differences of 1, and its texel's centre an error of 1 / 12 in the mean square


class Anywhere:
    """Points of a Scene's receivers under and over a Still plane; casters block.

    positions, normals (K,3) and area (K,) of the points' texels, or, by `of`, all Texels; shades: look for what stands
    in the way.
    """

    _texels = ()

    def __init__(self, still, scene, positions, normals, area, shades=True):
        self._still, self._scene, self._shades = still, scene, shades
        if shades:
            *self._solids, self._tracer = solid((*scene.receivers, *scene.occluders, *scene.casters))
            self._above = bool((still.to_plane(self._solids[0])[2] > 0).any())
        self._p, self._n, self._area = still.to_plane(positions), still.frame @ normals.T, area

    @classmethod
    def of(cls, still, scene, texels, shades=True):
        """All Texels of a Scene's receivers."""
        places = (np.concatenate([getattr(t, name) for t in texels]) for name in ("positions", "normals", "area"))
        new = cls(still, scene, *places, shades)
        new._texels = texels
        return new

    def under(self, light, work):
        """As `OneFloor.under`, of any light."""
        irradiance, doubts = np.zeros((len(self._area), 3)), []
        power = np.asarray(light.irradiance if isinstance(light, Sun) else light.intensity, float)
        cells, area = self._still.cells() if isinstance(light, Point) else self._still.whole()
        turned = paths(self._still, light, cells, self._scene.eta, False)
        if turned is None:
            return irradiance, doubts
        passed = paths(self._still, light, cells, self._scene.eta, True)
        going = {True: -(area * passed.strength * passed.arrives[2]).sum() * power}
        going[False] = (area * turned.strength * turned.arrives[2]).sum() * power
        lost = {}
        for through in (True, False):
            ids = np.flatnonzero(self._p[2] < 0 if through else self._p[2] > 0)
            e, books, off = self._by(light, ids, through)
            watts = np.outer(e, power)
            kept = np.exp(-np.outer(books["length"], self._scene.sigma_a)) if through else np.ones((1, 3))
            arrived = self._area[ids] @ (watts * kept)
            irradiance[ids] += watts * kept
            per = (power * kept).mean() ** 2 / len(self._area) if len(ids) else 0.0
            doubts += [replace(one, scale=per * one.scale, points=per * one.points) for one in off]
            if through:
                shaded = books["shaded"] * power
                absorbed = self._area[ids] @ watts - arrived
                lost = {"occluded": shaded, "absorbed": absorbed, "missed": going[True] - shaded - absorbed - arrived}
            else:
                lost["reflected"] = going[False] - arrived
        book(work, lost, going[True] + going[False])
        return irradiance, doubts

    def _by(self, light, ids, through):
        """Irradiance (n,) at texels ids (n,) per unit of the light's power without absorption; the `length` (n,) of the
        ways and what is `shaded`; and the Doubts, in sum over texels."""
        if not len(ids):
            return np.zeros(0), {"length": np.zeros(0), "shaded": 0.0}, ()
        ways = paths(self._still, light, self._p[:, ids], self._scene.eta, through)
        facing = np.maximum(-dot(ways.arrives, self._n[:, ids]), 0.0)
        # A lamp in the water's own plane sends no light through it, and has no way to tell of.
        bare, length = (np.nan_to_num(v, nan=0.0, posinf=0.0) for v in (ways.strength * facing, ways.length))
        water = self._still.covered(*ways.enters)
        e = bare * water
        at = np.flatnonzero(e > 0)
        hidden, above = self._hidden(ways, at) if self._shades else (np.zeros(len(at), bool), 0.0)
        hidden = at[hidden]
        shaded = float(self._area[ids[hidden]] @ e[hidden])
        bare[hidden] = e[hidden] = 0
        bare[water == 0] = np.nan  # no ray was sent there
        books = {"length": length, "shaded": shaded}
        if not e.any():
            return e, books, ()
        return e, books, (self._doubt(light, ids, ways, (e, bare), through, above),)

    def _hidden(self, ways, at):
        """Whether (n,) something stands in Paths `at` (n,), above the plane or behind it; and how far [m] above it, in
        the mean over them."""
        enters = np.concatenate([ways.enters[:, at], np.zeros((1, len(at)))])
        m, along, towards = self._still.to_world(enters), _some(ways.arrives, at), _some(ways.towards, at)
        frame = self._still.frame
        hidden = self._tracer.blocked(m, along.T @ frame, ways.length[at])
        if not self._above:
            return hidden, 0.0
        rest = np.flatnonzero(~hidden)
        away = ways.away if np.isscalar(ways.away) else ways.away[at[rest]]
        hidden[rest] = self._tracer.blocked(m[rest], towards[:, rest].T @ frame, away)
        above = rest[hidden[rest]]
        pick = above[some(len(above))]
        far = self._far(m[pick], towards[:, pick].T @ frame).mean() if len(pick) else 0.0
        return hidden, float(far * len(above) / max(np.count_nonzero(hidden), 1))

    def _far(self, m, towards):
        """How far (n,) [m] it is from points m (n,3) along `towards` (n,3) to what is first met."""
        positions, triangles = self._solids
        met = self._tracer.first(m, towards)
        v0, v1, v2 = (positions[triangles[met, k]] for k in range(3))
        across = np.cross(v1 - v0, v2 - v0)
        fall = (across * towards).sum(1)
        return np.where(met == MISS, 0.0, (across * (v0 - m)).sum(1) / np.where(fall == 0, np.inf, fall))

    def _doubt(self, light, ids, ways, shares, through, above):
        """The Doubt, in sum over texels, of the shares (n,) e and `bare` of a light, of which the first is
        shaded by the rim of the water too; above [m]: how far from the plane what shades is, in the mean."""
        e, bare = shares
        lit = np.flatnonzero(e > 0)
        pick = lit[some(len(lit))]
        border, bends = self._steps(ids, e)
        points = (self._steps(ids, bare)[1] + bends / FINER**2) / _BENDS
        texel = np.sqrt(self._area.mean())
        border = Border(border / len(lit), texel, above)
        scale = len(lit) / max(len(pick), 1)
        return Doubt(light, ways.take(pick), e[pick], self._scene.eta, through, border, scale, points)

    def _steps(self, ids, e):
        """Sums of the squared first and second differences of light e (n,) of texels ids (n,) along both axes of their
        images: small but where it ends."""
        light = np.zeros(len(self._area))
        light[ids] = e
        sums, start = np.zeros(2), 0
        for own in self._texels:
            image = np.full(own.resolution**2, np.nan)
            image[own.texel] = light[start : start + len(own.texel)]
            start += len(own.texel)
            image = image.reshape(own.resolution, own.resolution)
            for axis in (0, 1):
                step = np.diff(image, axis=axis)
                sums += np.nansum(step * step), np.nansum(np.square(np.diff(step, axis=axis)))
        return sums


def _some(vectors, at):
    """Vectors (3,n) of (3,m) or of one (3,1) for all."""
    return np.repeat(vectors, len(at), 1) if vectors.shape[1] == 1 else vectors[:, at]
