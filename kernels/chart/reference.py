"""What all methods are judged by: light by the complete method, fine, twice, with what is known of its error.

The two replicas differ in all that has a fineness: the parts of the water's surface, the beams, the seed. The disc of a
sun is no convolution here, as in the methods that are judged, but many suns without width, drawn evenly over the disc,
others in each replica. The mean of the two is the reference.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from ..anchor import Kept
from ..disc.disc import within_disc
from ..methods import prepare, solve
from ..scene import Sun
from ..sound_water import sound_water
from ..surface.reconstruct import Need
from ..terms import left_in
from .maps import Maps, light_of

# Relative mean squared errors that the parts of the surface and the beams leave in each replica, at most. Those of the
# beams of many suns differ, and their mean has a part of them.
_SURFACE, _BEAMS = (5e-4, 2e-4), (1e-2, 5e-3)
_CASTER_BEAMS = 1e-3, 3e-4  # over casters, what beams miss of a focus is alike for all suns
_FINE_SURFACE, _FINE_BEAMS = (3e-5, 1e-5), (1e-5, 3e-6)  # where no light is wide, one run is enough
_BUDGET = 30.0  # CPU s for both replicas, as far as that gives the least number of suns
_SUNS = 4, 48  # of each replica
_SEED = 5


@dataclass(frozen=True)
class Reference:
    """maps: the Maps of the light; error: the variance of the reference as its replicas tell it, or the error that they
    have in common as far as is known, over the mean square, as Settings.tolerance counts; flux_error: standard error
    of the whole flux, relative; suns: how many stand for a sun's disc, 0 where none is wide; seconds that it took."""

    maps: Maps
    error: float
    flux_error: float
    suns: int
    seconds: float


def reference(scene, texels, settings):
    """Yield a sentence on each step; returns the Reference of a Scene on Texels, for what `settings` ask for."""
    start = time.process_time()
    scene, settings = left_in(scene, replace(settings, method="photon_splat", first_root=False, points=False))
    yield "reference: the surface"
    kept = Kept(prepare(scene, texels, settings))
    replicas = [_Replica(scene, texels, settings, kept, number) for number in (0, 1)]
    count = 0
    if any(map(_wide, scene.lights)):
        begin = time.process_time()
        replicas[0].light(_suns(scene.lights, 1, 0)[0])
        count = int(np.clip(_BUDGET / 2 / (time.process_time() - begin), *_SUNS))
    total, doubt = [], 0.0
    for number, replica in enumerate(replicas):
        parts = 0.0
        for lights in _suns(scene.lights, count, number):
            yield f"reference: half {number + 1} of 2" + (f", {count} suns in the place of its disc" if count else "")
            light, doubt = replica.light(lights)
            parts = parts + light / max(count, 1)
        total.append(parts)
    # What both have in common does not show: their surfaces, and beams, whose errors many suns even out over water.
    least = replicas[1].surface_error + (0.0 if count and not scene.casters else doubt)
    return _of(texels, *total, least, count, time.process_time() - start)


def _of(texels, first, second, least, suns, seconds):
    """The Reference of two replicas' light (K,3), with an error of `least` at least."""
    maps = Maps.of(texels, (first + second) / 2)
    apart = maps.light + (first - second) / 2  # half the difference has the variance of the mean
    error = max(maps.error(apart), least)
    return Reference(maps, error, abs(maps.energy(apart)), suns, seconds)


class _Replica:
    """One of the two pictures."""

    def __init__(self, scene, texels, settings, kept, number):
        self._texels = texels
        wide = _CASTER_BEAMS if scene.casters else _BEAMS
        tolerance = (wide if any(map(_wide, scene.lights)) else _FINE_BEAMS)[number]
        self._scene, self.surface_error = smooth(scene, texels, settings, kept, number)
        self._settings = replace(settings, tolerance=tolerance, seed=settings.seed + number, surface="mesh")

    def light(self, lights):
        """Light (K,3) of some lights together, and what the method says of its error."""
        solution = solve(replace(self._scene, lights=lights), self._texels, self._settings)
        return light_of(self._texels, solution.images), solution.diagnostics.estimated_error


def smooth(scene, texels, settings, kept, replica=0):
    """The Scene with the water that a replica of the reference is made of, where `settings` ask for a smooth one, and
    the relative mean squared error that its triangles leave."""
    if settings.surface != "auto" or not len(scene.water.triangles):
        return scene, 0.0
    water, _ = sound_water(scene.water)
    # With the disc that the lights have, which blurs what a surface leaves.
    error = (_SURFACE if any(map(_wide, scene.lights)) else _FINE_SURFACE)[replica]
    water, _ = kept.reconstruction.apply(water, Need.of(scene, texels, error))
    return replace(scene, water=water), kept.reconstruction.error


def _wide(light):
    return isinstance(light, Sun) and light.angle > 0


def _suns(lights, count, number):
    """Lights without width that stand for `lights` in the mean: `count` tuples of them, one where none is wide."""
    if not count:
        return [lights]
    rng = np.random.default_rng([_SEED, number])
    turned = [within_disc(light, count, rng) if _wide(light) else [light] * count for light in lights]
    return list(zip(*turned, strict=True))
