"""Caustics mapping [1]: the water in the light's view, as a grid of points that are refracted, landed and splatted.

What bends light is drawn from the light, and so are the receivers. Where a bent ray meets them is not intersected but
looked up, again and again (`estimate.py`); each point leaves its flux there as a Gaussian. The maps of [1] are in the
light's view, and receivers look them up; here receivers have lightmaps, and take the splats themselves.
Soft: as fine as the grid, whatever the mesh. Its error is told from the same map by a half and a quarter of the grid,
with one look-up more.

[1] Shah, Konttinen & Pattanaik 2007, Caustics Mapping: An Image-space Technique for Real-time Caustics.
"""

from __future__ import annotations

import time

import numpy as np

from ..casters import Glass
from ..scene import Diagnostics, Sun
from ..solution import answer, book, check_texels
from ..status import Status
from .estimate import estimate, newton, start
from .gaussian import splat
from .landing import Landing
from .things import CasterThing, WaterThing

_GRIDS = 128, 1024  # the source's, and the finest that is tried
# The error over the squared difference to the map by half of the grid, as seen on pools, suns and lamps: where these
# differences fall by this factor or more, so that the light is resolved, 0.1 to 0.6 for small ones, and as many times
# that as they are over 0.01, up to 5; elsewhere up to 15.
_FALLING, _RESOLVED, _SMALL, _MOST, _UNRESOLVED = 0.7, 0.5, 1e-2, 5.0, 10.0
_REASON = "splats of a grid in the light's view, landed by look-ups"
_LEFT_OUT = [
    "what is finer than a splat of the grid",
    "light that lands where the lamp's straight view of the receivers shows nothing, or something else",
    "light that meets the water twice, and that goes from glass or metal into the water",
]
_TWO_SURFACES = "in glass, all but two surfaces, the second guessed from the lamp's view: no error is estimated for it"


def solve(scene, texels, settings):
    """Irradiance of a Scene on Texels (one per receiver) by caustics maps; see `scene.Solution`.

    Settings.iterations, 1 to 5, is how often a landing point is looked up again; Settings.grid the number of points
    along the water as the light sees it, 0 for as many as the tolerance asks for, while more of them help. Raises
    ValueError for others, and where texels and receivers do not match.
    """
    check_texels(scene, texels)
    if not 1 <= settings.iterations <= 5 or settings.grid < 0:
        raise ValueError(
            f"iterations must be 1 to 5 and grid not negative, got {settings.iterations} and {settings.grid}"
        )
    start = time.perf_counter()
    maps = [Map(scene, light, texels, settings) for light in scene.lights] if any(len(t.texel) for t in texels) else []
    seconds = {"prepare": time.perf_counter() - start}
    start, grid = time.perf_counter(), settings.grid or _GRIDS[0]
    irradiance, error, work = _by(maps, texels, grid, settings)
    before = np.inf
    while not settings.grid and settings.tolerance < error < _FALLING * before and 2 * grid <= _GRIDS[1]:
        grid, before = 2 * grid, error
        irradiance, error, work = _by(maps, texels, grid, settings)
    work.seconds = {**seconds, "map": time.perf_counter() - start}
    work.reason += f", {grid} points along it"
    work.left_out = list(_LEFT_OUT)
    if any(isinstance(caster.material, Glass) for caster in scene.casters):
        work.left_out.append(_TWO_SURFACES)
    else:
        work.estimated_error = error
    return answer(scene, texels, irradiance, np.where(irradiance.any(1), Status.LIT, Status.DARK), work)


def _by(maps, texels, grid, settings):
    """Irradiance (K,3) of Maps by a grid, its estimated error, and the books."""
    work = Diagnostics("caustic_map", _REASON)
    levels = np.zeros((3, sum(len(t.texel) for t in texels), 3))
    for one in maps:
        light, lost, met, points = one.draw(grid, settings.iterations)
        book(work, lost, met)
        work.paths["splats"] = work.paths.get("splats", 0) + points
        levels[0] += light
        for k in (1, 2):
            levels[k] += one.draw(max(grid >> k, 1), settings.iterations + 1)[0]
    area = np.concatenate([np.zeros(0), *(t.area for t in texels)])
    arrived, occluded = (area @ levels[0]).sum(), np.sum(work.flux_lost.get("occluded", 0.0))
    doubt = occluded / arrived if arrived > 0 else 0.0  # as much as that may in truth have passed behind what is seen
    return levels[0], _left(levels.mean(2)) + float(doubt), work


def _left(levels):
    """Mean squared error over the squared mean of the first of three maps (3,K), each by half of the grid of the one
    before, from their differences."""
    mean = levels[0].mean() if levels.size else 0.0
    if not mean > 0:
        return 1.0  # if there is light, all of it is missing
    one, two = (((levels[k] - levels[k + 1]) ** 2).mean() / mean**2 for k in (0, 1))
    resolved = _RESOLVED * np.clip(one / _SMALL, 1, _MOST)
    return float(one * (resolved if one < _FALLING * two else _UNRESOLVED))


class Map:
    """The caustics map of one light of a Scene on Texels."""

    def __init__(self, scene, light, texels, settings):
        self._texels = texels
        self._power = np.asarray(light.irradiance if isinstance(light, Sun) else light.intensity, float)
        things = [WaterThing(scene, light, texels, settings.tolerance)] if len(scene.water.triangles) else []
        if scene.casters:
            things.append(CasterThing(scene, light))
        self._things = [(thing, Landing(scene.receivers, texels, thing.solids)) for thing in things if thing.visible]

    def draw(self, grid, iterations):
        """Irradiance (K,3), what is lost {cause: (3,)} [W], what came in (3,), and how many points did."""
        count = sum(len(t.texel) for t in self._texels)
        irradiance, lost, met, points = np.zeros((count, 3)), {}, np.zeros(3), 0
        for thing, landing in self._things:
            light, causes, came, seen = _draw(thing, landing, grid, iterations, self._texels)
            light = (light * self._power[:, None]).T if len(light) > 1 else light.T * self._power
            irradiance += thing.disc.blur_light(light) if thing.disc is not None and thing.disc.seen else light
            for cause, watts in causes.items():
                lost[cause] = lost.get(cause, 0.0) + watts * self._power
            met = met + came * self._power
            points += seen
        return irradiance, lost, met, points


def _draw(thing, landing, grid, iterations, texels):
    """Irradiance (C,K) per unit of the light's power by one Thing, what is lost {cause: (3,)}, what came in and how
    many points of it."""
    raster, seen, shadowed = thing.seen(grid)
    came, dark = seen.flux.sum(), seen.flux[shadowed].sum()
    lit = seen.take(np.flatnonzero(~shadowed))
    lost, light, passed = {"shadowed": np.full(3, dark)}, 0.0, np.zeros(3)
    cuts = np.cumsum([len(t.texel) for t in texels])[:-1]
    for bent in thing.bent(lit, raster):
        total = np.broadcast_to(bent.flux.sum(1), 3)
        passed = passed + total
        if bent.r is None:
            lost["reflected"] = lost.get("reflected", 0.0) + total
            continue
        land = newton if bent.mirrored else estimate
        positions = thing.positions(grid, bent.mirrored)
        point, triangle = land(positions, bent.v, bent.r, iterations, start(positions, bent.v) * bent.nearer)
        away = point - bent.v
        length = np.sqrt((away * away).sum(0))
        images, causes, sizes = landing.land(bent, point, triangle, length)
        owned, beside = landing.owned(images)
        causes["missed"] = causes["missed"] + beside
        for cause, watts in causes.items():
            name = "reflected" if bent.mirrored else cause
            lost[name] = lost.get(name, 0.0) + np.broadcast_to(watts, 3)
        area = np.concatenate([t.area for t in texels])
        parts = np.split(owned / area, cuts, axis=1)
        spread = [splat(p, t, w) for p, t, w in zip(parts, texels, landing.rest(sizes), strict=True)]
        light = light + np.concatenate(spread, axis=1)
    lost["kept"] = came - dark - passed
    return light, lost, came * np.ones(3), len(seen.triangle)
