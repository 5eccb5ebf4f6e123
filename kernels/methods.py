"""The methods, by the names that users type, and the choice between them."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from .anchor import Anchor, Kept
from .caustic_map import caustic_map
from .dispersion import etas, solve_channels
from .flat import flat
from .rays import SLOW
from .scene import SURFACES, Point
from .sound_water import sound_water
from .splat import photon_splat
from .sun_map import sun_map
from .surface.reconstruct import Need, prepared
from .terms import left_in
from .tile import tile
from .walk import conic_walk

METHODS = {
    "flat": flat.solve,
    "sun_map": sun_map.solve,
    "caustic_map": caustic_map.solve,
    "photon_splat": photon_splat.solve,
    "conic_walk": conic_walk.solve,
}
AUTO = "photon_splat"  # the one that finds all the light
_AS_IT_IS = {"flat": "the mean plane of the mesh", "sun_map": "the normals of the mesh"}  # methods that need no more
_OVER_CASTERS = ("photon_splat", "caustic_map")
_SURFACE = 0.7  # of the tolerance, at most: its parts cost most, and half the error takes 1.4 times as many


def prepare(scene, texels, settings):
    """The Anchor of an animation, found on one of its frames: a Scene and its Texels. Raises ValueError as `solve`."""
    if settings.tile:
        scene, _ = tile.widened(scene, settings.resolution)
    water, _ = sound_water(scene.water)
    scene, texels = _near_origin(replace(scene, water=water), texels)
    return Anchor(prepared(scene.water)) if settings.surface == "auto" else Anchor()


def solve(scene, texels, settings, kept=None):
    """The Solution of a Scene on Texels, one per receiver, by the method that `settings` asks for.

    kept: a `Kept` with the Anchor of the frame's animation; without one the frame stands alone. Raises ValueError for a
    method, surface or term that does not exist, for an impossible dispersion and for water with positions that are not
    finite.
    """
    if settings.tile:
        return tile.solve(lambda *wide: solve(*wide, kept), scene, texels, replace(settings, tile=False))
    method = AUTO if settings.method == "auto" else settings.method
    if method not in METHODS:
        raise ValueError(f"method must be auto or one of {', '.join(METHODS)}, got {settings.method!r}")
    if settings.surface not in SURFACES:
        raise ValueError(f"surface must be one of {', '.join(SURFACES)}, got {settings.surface!r}")
    scene, settings = left_in(scene, settings)
    water, sentences = sound_water(scene.water)
    scene, texels = _near_origin(replace(scene, water=water), texels)
    start, surface = time.perf_counter(), "the mesh as it is, as was asked for"
    reconstruction, smooth = (kept or Kept()).reconstruction, settings.surface == "auto"
    if method in _AS_IT_IS:
        smooth, surface = False, _AS_IT_IS[method]
    if not len(scene.water.triangles):
        smooth, surface = False, "there is no water"
    if smooth:
        water, surface = reconstruction.apply(scene.water, Need.of(scene, texels, _SURFACE * settings.tolerance))
        scene = replace(scene, water=water)
        left = max(settings.tolerance - reconstruction.error, (1 - _SURFACE) * settings.tolerance)
        settings = replace(settings, tolerance=left)
    seconds = time.perf_counter() - start
    answer = _as_cycles(solve_channels(METHODS[method], scene, texels, settings), scene, settings)
    answer.diagnostics.surface, answer.diagnostics.slow_rays = surface, SLOW
    if smooth and answer.diagnostics.estimated_error is not None:
        answer.diagnostics.estimated_error += reconstruction.error
    answer.diagnostics.seconds = {"surface": seconds, **answer.diagnostics.seconds}
    answer.diagnostics.left_out.extend(sentences)
    if scene.casters and method not in _OVER_CASTERS:
        answer.diagnostics.left_out.append("light over glass and mirrors: they block, and cast no caustics")
    return answer


def _as_cycles(answer, scene, settings):
    """The Solution with its images as Cycles shows them, where that is asked for; says what bent them and scaled them.

    Radiance that leaves the water for the air falls by eta^2, which Cycles leaves out: a map seen through its water is
    too bright by that much.
    """
    work = answer.diagnostics
    work.etas = etas(scene.eta, settings.dispersion)
    if not settings.match_cycles:
        return answer
    work.map_scale = 1 / work.etas**2
    return replace(answer, images=tuple(image * work.map_scale for image in answer.images))


def _near_origin(scene, texels):
    """The same scene and Texels with the water's middle, or the casters' where there is none, at the origin, unless
    they are near to it: far away, few digits are left for the waves."""
    meshes = (scene.water,) if len(scene.water.positions) else scene.casters
    positions = np.concatenate([np.zeros((0, 3)), *(mesh.positions for mesh in meshes)])
    if not len(positions):
        return scene, texels
    low, high = (np.array([reach(values) for values in positions.T]) for reach in (np.min, np.max))
    middle = (low + high) / 2
    if np.abs(middle).max() <= (high - low).max():
        return scene, texels

    def moved(thing):
        return replace(thing, positions=thing.positions - middle)

    groups = {name: tuple(map(moved, getattr(scene, name))) for name in ("receivers", "occluders", "casters")}
    lights = tuple(
        replace(light, position=light.position - middle) if isinstance(light, Point) else light
        for light in scene.lights
    )
    volume = scene.volume
    if volume is not None:
        back = np.eye(4)
        back[:3, 3] = -middle
        volume = replace(volume, matrix=back @ volume.matrix)
    scene = replace(scene, water=moved(scene.water), lights=lights, volume=volume, **groups)
    return scene, tuple(map(moved, texels))
