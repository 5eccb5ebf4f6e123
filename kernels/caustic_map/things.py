"""What bends light, as one light sees it: the water, and all casters together."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from ..disc.disc import Disc
from ..lit_water import light_water, may_be_shadowed
from ..rays import MISS
from ..scene import Sun
from .bending import Backs, Seen, from_casters, from_water
from .meshes import Shaded, Solids
from .positions import Positions
from .view import Raster, View

_FRAME = {False: 1.0, True: 8.0}  # of the thing's own size: how far beyond it receivers are looked at; mirrored: True
_EPS = 1e-9


class Thing:
    """A soup that bends the light of one lamp onto Solids, whose receivers lie in the view of that lamp.

    `bent(seen, raster)` yields the Bent light of what is Seen of it.
    """

    def __init__(self, scene, light, shaded, solids, axis):
        self._scene, self._shaded, self.solids = scene, shaded, solids
        corners = [shaded.positions.T, *(r.positions.T for r in scene.receivers)]
        everything = np.concatenate([*corners, *(o.positions.T for o in scene.occluders)], 1)
        self.view = View(light, axis, everything)
        self._bounds = self.view.bounds(corners[0])
        around = self.view.bounds(np.concatenate(corners[1:], 1))
        if self._bounds is not None and around is not None:
            low, high = self._bounds
            margin = {mirrored: part * (high - low).max() for mirrored, part in _FRAME.items()}
            self._frame = {
                k: (np.maximum(around[0], low - m), np.minimum(around[1], high + m)) for k, m in margin.items()
            }
        inside = self._bounds is not None and around is not None
        self.visible = inside and all((low < high).all() for low, high in self._frame.values())

    def seen(self, grid):
        """The Raster of `grid` cells along it, what is Seen in them, and whether (n,) that lies in a shadow."""
        raster = Raster(*self._bounds, grid)
        seen = Seen(self.view, self._shaded, raster)
        return raster, seen, self._shadowed(seen)

    def positions(self, grid, mirrored):
        """The Positions of what light meets that leaves it."""
        return Positions(self.view, self.solids, *self._frame[mirrored], grid, None if mirrored else self._start)

    def _start(self, origin, _direction):
        return origin

    def _shadowed(self, seen):
        start = seen.point + self._shaded.off * seen.towards
        return self.solids.blocked(start, seen.towards, seen.away)


class WaterThing(Thing):
    """The water; disc: what a sun's disc does to its light."""

    def __init__(self, scene, light, texels, tolerance):
        lit = light_water(scene.water, light)
        ids = np.flatnonzero(lit.area)
        mesh = SimpleNamespace(
            positions=lit.points,
            triangles=lit.triangles[ids],
            normals=lit.shading,
            normal_triangles=lit.normal_triangles[ids],
        )
        up = lit.facets.leaning @ lit.area
        solids = Solids(scene.receivers, (*scene.occluders, *scene.casters))
        super().__init__(scene, light, Shaded([mesh]), solids, -up / max(np.linalg.norm(up), _EPS))
        self._in_shadow = may_be_shadowed(lit, solids.positions, solids.triangles)[ids]
        self.disc = Disc(lit, scene.receivers, texels, scene.eta, light, tolerance, finest=1)
        level = (lit.points[lit.triangles[ids]] @ up).min(initial=np.inf)
        self._mirrors = any((r.positions @ up > level).any() for r in scene.receivers)

    def bent(self, seen, _raster):
        through, back = from_water(seen, self._scene.eta, np.asarray(self._scene.sigma_a, float))
        yield through
        yield back if self._mirrors else _nowhere(back)

    def _start(self, origin, direction):
        """Where rays are once they have passed the water."""
        triangle = self._shaded.first(origin, direction)
        hit = np.flatnonzero(triangle != MISS)
        point = self._shaded.meet(triangle[hit], origin[:, hit], direction[:, hit])[0]
        origin = origin.copy()
        origin[:, hit] = point + self._shaded.off * direction[:, hit]
        return origin

    def _shadowed(self, seen):
        shadowed = np.zeros(len(seen.triangle), bool)
        at = np.flatnonzero(self._in_shadow[seen.triangle])
        if len(at):
            shadowed[at] = super()._shadowed(seen.take(at))
        return shadowed


class CasterThing(Thing):
    """Casters: they stand before the water, which ends their light."""

    disc = None

    def __init__(self, scene, light):
        shaded = Shaded(scene.casters)
        middle = (shaded.positions.max(0) + shaded.positions.min(0)) / 2
        axis = np.array([0.0, 0.0, -1.0]) if isinstance(light, Sun) else middle - light.position
        solids = Solids(scene.receivers, (*scene.occluders, scene.water))
        super().__init__(scene, light, shaded, solids, axis / max(np.linalg.norm(axis), _EPS))

    def bent(self, seen, raster):
        backs = Backs(self.view, self._shaded, raster)
        yield from from_casters(seen, self._shaded, self._scene.casters, backs)


def _nowhere(bent):
    """Light that no receiver can take."""
    bent.r = None
    return bent
