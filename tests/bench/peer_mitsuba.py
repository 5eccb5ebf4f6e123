"""Mitsuba 3 on a Scene: photons aimed at what bends light, and its own `ptracer` where a camera can see the map.

Run by `peers.py`. `mitsuba_light.py` leaves photons on texels, on all receivers; `ptracer` shoots at the whole scene
and draws what a camera sees, a pixel to a texel, of a plane square receiver about the origin. Its sun's disc is a
number of suns without width.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

PHOTONS = 2**18, 2**20, 2**22
_SUNS = 32
_FAR = 20.0  # m, of the camera over a table


def runs(scene, texels):
    """Yield the runs of Mitsuba on a Scene."""
    import drjit
    import mitsuba

    from dapple.kernels.scene import Area

    if any(isinstance(light, Area) for light in scene.lights):
        raise ValueError("area lamps are not handed to Mitsuba")
    mitsuba.set_variant("llvm_ad_rgb")
    drjit.set_thread_count(1)
    yield from _aimed(scene, texels)
    yield from _ptracer(scene, texels)


def _aimed(scene, texels):
    from bench import mitsuba_scene
    from bench.caster_references import irradiance
    from bench.mitsuba_light import LightTracer
    from bench.peers import run_of

    if len({own.resolution for own in texels}) > 1:
        raise ValueError("its photons are for maps of one size")
    tracer = LightTracer(scene, mitsuba_scene.load(scene), texels[0].resolution)
    tracer.throw(PHOTONS[0], 1)  # all that is compiled is, from here on
    for photons in PHOTONS:
        seconds, landed = _timed(lambda n=photons: tracer.throw(n, 2))
        yield run_of("Mitsuba 3, aimed photons", f"{photons} photons", seconds, irradiance(texels, landed.maps))


def _ptracer(scene, texels):
    from bench.mitsuba_camera import MapCamera
    from bench.peers import run_of

    view = _view(scene)
    if view is None:
        return
    own, count = texels[0], sum(len(t.texel) for t in texels)
    camera = MapCamera(replace(scene, lights=_narrow(scene.lights)), view, own)
    seen = np.zeros(count, bool)
    seen[: len(own.texel)] = camera.on_map(camera.seen)[own.texel]
    camera.whole(max(1, PHOTONS[0] // own.resolution**2), 1)
    for photons in PHOTONS:
        paths = photons // own.resolution**2
        if paths:
            seconds, whole = _timed(lambda n=paths: camera.whole(n, 2))
            light = np.zeros((count, 3))
            light[: len(own.texel)] = camera.on_map(whole - camera.straight(paths, 2))[own.texel]
            yield run_of("Mitsuba 3, ptracer", f"{paths} paths a texel", seconds, light, seen)


def _timed(run):
    """CPU seconds of run(), and what it returned."""
    start = time.process_time()
    result = run()
    return time.process_time() - start, result


def _view(scene):
    """The View of a MapCamera on the first receiver, from under the water or from afar; None where that is no plane
    square at z = 0 about the origin."""
    from bench.mitsuba_camera import View

    first = scene.receivers[0]
    low, high = first.positions.min(0), first.positions.max(0)
    side = high[0] - low[0]
    square = np.abs(low[:2] + high[:2]).max() < 1e-4 * side and abs(high[1] - low[1] - side) < 1e-4 * side
    plan = np.abs(first.uvs - first.positions[first.triangles][..., :2] / side - 0.5).max() < 1e-4
    if not (square and plan and np.abs(first.positions[:, 2]).max() < 1e-4 * side):
        return None
    height = 0.8 * scene.water.positions[:, 2].min() if len(scene.water.triangles) else _FAR
    return View((0, 0, float(height)), float(side))


def _narrow(lights):
    from dapple.kernels.disc.disc import within_disc

    suns = []
    for light in lights:
        wide = getattr(light, "angle", 0.0) > 0
        parts = within_disc(light, _SUNS, np.random.default_rng(1)) if wide else [light]
        suns += [replace(part, irradiance=part.irradiance / len(parts)) if wide else part for part in parts]
    return tuple(suns)


if __name__ == "__main__":
    from bench_stages import load_dapple

    load_dapple()
    from bench.peers import answer

    answer(runs)
