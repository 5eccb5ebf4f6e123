"""The methods, by the names that users type, and the choice between them."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np

from .anchor import Anchor, Kept
from .area_lamps import cut
from .caustic_map import caustic_map
from .dispersion import etas, solve_channels
from .flat import flat
from .flat.level import Level
from .maps.packed import packed
from .plan.planner import planned
from .plan.words import reason, told
from .rays import SLOW
from .scene import SURFACES, Point
from .sound_scene import check_scene, check_settings
from .sound_water import sound_normals, sound_water
from .splat import photon_splat
from .sun_map import sun_map
from .surface.reconstruct import prepared
from .surface.share import Surface
from .surface.smoothing import Smoothing
from .terms import left_in
from .tile import tile
from .trace.steady import step
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


def prepare(scene, texels, settings):
    """The Anchor of an animation, found on one of its frames: a Scene and its Texels. Raises ValueError as `solve`."""
    check_settings(settings)
    check_scene(scene)
    if sheets := packed(scene, texels):
        scene, texels = sheets.scene, sheets.texels
    if settings.tile:
        scene, _ = tile.widened(scene, texels[0].resolution)
    scene, texels, settings, _ = _ready(scene, texels, settings)
    smoothing = prepared(scene.water) if settings.surface == "auto" else Smoothing()
    plan = planned(scene, texels, settings, smoothing) if _plans(settings) else None
    method = settings.method if plan is None else plan.choice.method
    return Anchor(smoothing, plan, Level.of(scene.water) if method == "flat" else None)


def solve(scene, texels, settings, kept=None):
    """The Solution of a Scene on Texels, one per receiver, each of its own resolution, by the method of `settings`.

    kept: a `Kept` with the Anchor of the frame's animation; without one the frame stands alone. Raises ValueError for a
    method, surface or term that does not exist, for an impossible dispersion and for what `sound_scene.py` refuses.
    """
    if sheets := packed(scene, texels):
        check_scene(scene)  # of what is too small: packed, it is not seen
        return sheets.unpack(solve(sheets.scene, sheets.texels, settings, kept))
    if settings.tile:
        return tile.solve(lambda *wide: solve(*wide, kept), scene, texels, replace(settings, tile=False))
    light = None if kept is None else kept.light  # a frame that stands alone keeps its light for none
    kept, start, plan = kept or Kept(), time.perf_counter(), None
    scene, texels, settings, sentences = _ready(scene, texels, settings)
    if _plans(settings):
        plan = planned(scene, texels, settings, kept.anchor.smoothing, kept.anchor.plan)
        scene, settings = left_in(scene, plan.settings(settings))
    seconds = {"plan": time.perf_counter() - start}
    start = time.perf_counter()
    method = AUTO if settings.method == "auto" else settings.method
    surface = Surface.of(scene, texels, settings, kept.reconstruction, plan, _AS_IT_IS.get(method))
    scene, settings = surface.scene, surface.settings
    seconds["surface"] = time.perf_counter() - start
    answer = solve_channels(_by(method, kept.still, light), scene, texels, settings)
    work = answer.diagnostics
    work.surface, work.slow_rays, work.seconds = surface.sentence, SLOW, {**seconds, **work.seconds}
    work.estimated_error = surface.estimate(answer)
    work.left_out.extend(sentences)
    if plan is not None:
        work.reason, work.plan = reason(plan, work.estimated_error), told(plan)
    if scene.casters and method not in _OVER_CASTERS:
        work.left_out.append("light over glass and mirrors: they block, and cast no caustics")
        work.estimated_error = None  # how much that is, the method does not know
    return _as_cycles(answer, scene, settings)


def _by(method, still, light):
    """What solves by a method, with the KnownStill and the KeptLight, or None, of other frames."""
    own = {"flat": still.solve, AUTO: partial(photon_splat.solve, kept=light)}
    return own.get(method, METHODS[method])


def _ready(scene, texels, settings):
    """Scene, Texels and Settings without what is not asked for, sound, and near the origin; and sentences on that."""
    if settings.method not in ("auto", *METHODS):
        raise ValueError(f"method must be auto or one of {', '.join(METHODS)}, got {settings.method!r}")
    if settings.surface not in SURFACES:
        raise ValueError(f"surface must be one of {', '.join(SURFACES)}, got {settings.surface!r}")
    check_settings(settings)
    scene, settings = left_in(scene, settings)
    check_scene(scene)
    water, sentences = sound_water(scene.water)
    found = [sound_normals(caster, f"'{caster.name}'") for caster in scene.casters]
    scene = replace(scene, water=water, casters=tuple(caster for caster, _ in found))
    scene, of_lamps = cut(scene, texels, settings.tolerance)
    return *_near_origin(scene, texels), settings, sentences + [said for _, own in found for said in own] + of_lamps


def _plans(settings):
    """Whether the planner is to choose: points are the complete method's own check."""
    return settings.method == "auto" and not settings.points


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
    middle = np.round((low + high) / 2 / step(low, high)) * step(low, high)  # it stays while things move a little
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
