"""Photon splatting: the forward estimator. Complete - every path that the water bends - and it keeps the energy.

By default a photon is a beam, a triangle of the water with its true footprint (`beams.py`): no noise. As points, the
photons start stratified on the water, are refracted once and land on the first surface below; half of them are drawn
apart from the other half, and the difference of the two pictures is the estimate of the error. Points are the
independent check of the beams. After [1] caustics volumes (De Barro et al.), [2] caustics mapping (Shah et al. 2007)
and [3] collection points (Moreau & Doggett 2022), with footprints and strata in place of their random photons.
"""

from __future__ import annotations

import time
from itertools import chain, cycle

import numpy as np

from ..area_lamps import among, lamp_of
from ..scene import Diagnostics
from ..solution import answer, book, check_texels
from ..status import Status
from ..trace.cast import over_casters
from ..trace.left_out import left_out
from .halves import until_good
from .surroundings import Surroundings
from .ways import AGAIN, Lit

_POINTS = "points find every path"
_BEAMS = "beams find every path, without noise, whatever the receiver"
_OVER_CASTERS = "; over glass and metal points land what is weak or torn, with some"
_LEFT_OUT = [
    "what lies between the rays: objects less than a texel wide as the light sees them count in part",
    "penumbrae of objects as wide as they are: they get the width of the water's own",
    "the size of point and spot lamps: light comes from their centre",
]

_BACKS = "a few per cent of the light next to normals whose back it meets, where what passes falls to nothing"


def solve(scene, texels, settings, kept=None):
    """Irradiance of a Scene on Texels (one per receiver) by photons; see `scene.Solution`.

    Settings.tolerance is the relative mean squared error that is good enough, against the same mesh; Settings.points
    asks for points; kept: the `KeptLight` of the animation's frames. Raises ValueError where texels and receivers do
    not match.
    """
    check_texels(scene, texels)
    reason = _POINTS if settings.points else _BEAMS + (_OVER_CASTERS if scene.casters else "")
    work = Diagnostics("photon_splat", reason, left_out=list(_LEFT_OUT))
    start = time.perf_counter()
    casts = over_casters(scene, texels, settings, kept)
    over_water = _over_water(scene, texels, settings)
    work.seconds["prepare"] = time.perf_counter() - start
    start = time.perf_counter()
    if settings.points:
        lights = [*over_water, *casts]
        irradiance = until_good(lights, texels, settings, work).mean(0)
        again = sum(lit.again() for lit in lights)
    else:
        irradiance, again = _by_beams(chain(over_water, casts), scene, texels, work)
    work.seconds["photons"] = time.perf_counter() - start
    _tell_of_second_meetings(again, settings.tolerance, work)
    work.left_out += left_out(scene, texels, settings, work, casts)
    return answer(scene, texels, irradiance, np.where(irradiance.any(1), Status.LIT, Status.DARK), work)


def _over_water(scene, texels, settings):
    """Yield a Lit for each light, if there is water: they are large, and lamps may be in many pieces."""
    if len(scene.water.triangles):
        around = Surroundings(scene, texels, settings)
        yield from (Lit(light, around) for light in scene.lights)


def _by_beams(lights, scene, texels, work):
    """Irradiance (K,3) by beams of what follows the lights, and how many rays met the water again; books what comes in
    and what is lost."""
    area = np.concatenate([t.area for t in texels])
    flux = np.zeros((3, len(area))).T  # a row in memory per channel
    again, beams, backs, errors = 0, 0, False, {}
    for lit, light in zip(lights, cycle(scene.lights)):
        owned, lost, met, error = lit.spread()
        flux += owned
        key = lamp_of(light), isinstance(lit, Lit)
        errors[key] = errors.get(key, 0.0) + error / among(light) ** 2
        book(work, lost, met)
        again, beams = again + lit.again(), beams + np.count_nonzero(lit.water.area)
        backs = backs or lit.water.meets_backs()
    work.estimated_error = max(errors.values(), default=0.0)
    work.paths = {"beams": beams}
    work.left_out += [_BACKS] if backs else []
    return flux / area[:, None], again


def _tell_of_second_meetings(again, tolerance, work):
    """Say how many rays met the water again, and whether more of their light than the tolerance was not followed."""
    if again:
        work.paths["rays_that_meet_the_water_again"] = again
    weaker = sum(work.flux_lost.get(cause, np.zeros(3)).sum() for cause in AGAIN)
    if weaker > tolerance * work.flux_in.sum():
        part = weaker / work.flux_in.sum()
        work.left_out.append(f"the weaker part of light that meets the water twice: {part:.1%} of all that comes in")
