"""What caustics volumes and caustics mapping claim, measured: photons and surfaces; look-ups and grids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dapple.kernels.caustic_map.estimate import estimate, newton, start
from dapple.kernels.caustic_map.things import WaterThing
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings
from dapple.kernels.trace.cast import over_casters

from . import caster_scenes
from .accuracy_meshes import exact
from .accuracy_ponds import pool
from .source_water import scaled, timed

SIDES = (64, 128, 256)
PHOTON_HEAD = "scene", "photons", "CPU [s]", *(f"MAE at {n} x {n} texels" for n in SIDES)
BUFFER_HEAD = "scene", "pixels a side", "CPU [s]", "light", "MAE"
SURFACE_HEAD = "scene", "surfaces at most", "light", "MAE"
LOOK_UP_HEAD = "floor and sun", "look-ups after the first", "off, in texels, from here", "from x = 1 m", "by Newton"
GRID_HEAD = "waves", "points along the water", "CPU [s]", "error", "own estimate, over the squared mean", "MAE"
GLASS_HEAD = "scene", "method", "CPU [s]", "light", "MAE"
SCENES = ("ball", "stone", "ring")
SIDE = 128


def _caster_scene(name, side=SIDE):
    scene = getattr(caster_scenes, name)()
    return scene, [rasterise(r, side) for r in scene.receivers]


def _judged(image, true):
    """Mean absolute error over the mean, and mean squared error over the mean square, as the tolerance is."""
    off = image - true
    return f"{np.abs(off).mean() / true.mean():.3f}", f"{(off**2).mean() / (true**2).mean():.1e}"


def photon_rows():
    """Rows for PHOTON_HEAD: so many points on the casters, stratified, against beams at 1e-2, on maps of SIDES; time on
    the one of SIDE."""
    for name in SCENES:
        maps = [_thrown(name, side) for side in SIDES]
        for photons in (1e4, 2e4, 5e4, 1e6):
            seconds, errors = zip(*(throw(photons) for throw in maps), strict=True)
            yield name, int(photons), f"{seconds[SIDES.index(SIDE)]:.3f}", *(f"{error:.3f}" for error in errors)


def _thrown(name, side):
    """throw(photons): CPU seconds and the mean absolute error over the mean of so many points on a map."""
    scene, texels = _caster_scene(name, side)
    true = solve(scene, texels, Settings(tolerance=1e-2)).images[0][..., 0]
    cast, count = over_casters(scene, texels, Settings())[0], len(texels[0].texel)

    def throw(photons):
        seconds, (flux, *_) = timed(lambda: cast.throw(photons, np.random.default_rng(0)))
        image = texels[0].image(flux[:count] / texels[0].area[:, None])[..., 0]
        return seconds, np.abs(image - true).mean() / true.mean()

    return throw


def buffer_rows():
    """Rows for BUFFER_HEAD: what light meets first and last, in buffers of pixels, as one slab has them, with a photon
    to each pixel and what becomes of it in the two."""
    for name in SCENES:
        scene, texels = _caster_scene(name)
        true = solve(scene, texels, Settings(tolerance=1e-2)).images[0][..., 0]
        for pixels in (100, 200, 500):
            settings = Settings("caustic_map", grid=pixels)
            seconds, answer = timed(lambda s=scene, t=texels, how=settings: solve(s, t, how), 1)
            image = answer.images[0][..., 0]
            share = f"{100 * image.sum() / true.sum():.0f} %"
            yield name, pixels, f"{seconds:.2f}", share, _judged(image, true)[0]


def surface_rows():
    """Rows for SURFACE_HEAD: light that meets no more than so many surfaces, as slabs bound it, of that of 12."""
    for name in SCENES:
        scene, texels = _caster_scene(name)
        true = solve(scene, texels, Settings(tolerance=3e-2, bounces=12)).images[0][..., 0]
        for bounces in (1, 2, 4, 6):
            image = solve(scene, texels, Settings(tolerance=3e-2, bounces=bounces)).images[0][..., 0]
            yield name, bounces, f"{100 * image.sum() / true.sum():.1f} %", _judged(image, true)[0]


def look_up_rows():
    """Rows for LOOK_UP_HEAD: how far from the ray's true end the look-ups land, root mean square in texels of 512^2."""
    low = np.array([np.sin(np.radians(60)), 0, -np.cos(np.radians(60))])
    ponds = {
        "level, sun at 15 degrees from overhead": pool(),
        "uneven, the same sun": pool().with_relief(),
        "level, 60 degrees from overhead": replace(pool(), direction=low),
        "uneven, 60 degrees": replace(pool(), direction=low).with_relief(),
    }
    for name, pond in ponds.items():
        scene = pond.scene(exact(pond, 128))
        texels = [rasterise(r, 64) for r in scene.receivers]
        thing = WaterThing(scene, scene.lights[0], texels, 1e-2)
        raster, seen, _ = thing.seen(256)
        bent = next(thing.bent(seen, raster))
        positions = thing.positions(512, False)
        hit = thing.solids.first(bent.v, bent.r)
        true = thing.solids.meet(np.maximum(hit, 0), bent.v, bent.r)[0]
        within = (hit >= 0) & (np.abs(true[:2]).max(0) < 1.8)
        begin = start(positions, bent.v)
        for n in (1, 2, 3, 5):
            cells = []
            for method, x in ((estimate, begin * bent.nearer), (estimate, np.ones(len(begin))), (newton, begin)):
                point, _ = method(positions, bent.v, bent.r, n, x)
                off = np.sqrt(((point - true)[:, within] ** 2).sum(0))
                cells.append(f"{np.sqrt(np.nanmean(off**2)) * 512 / pond.floor.side:.2f}")
            yield name, n, *cells


def grid_rows():
    """Rows for GRID_HEAD at 256^2 texels: the pool's waves, and a third as high, on a level floor."""
    for name, scale in (("pool", 1.0), ("a third as high", 1 / 3)):
        pond = scaled(pool(), scale)
        scene = pond.scene(exact(pond, 128))
        own = [rasterise(scene.receivers[0], 256)]
        true = solve(scene, own, Settings(tolerance=1e-5, surface="mesh")).images[0][..., 0]
        for grid in (64, 128, 256, 512):
            settings = Settings("caustic_map", surface="mesh", grid=grid)
            seconds, answer = timed(lambda s=scene, t=own, how=settings: solve(s, t, how), 1)
            mean, squared = _judged(answer.images[0][..., 0], true)
            yield name, grid, f"{seconds:.3f}", squared, f"{answer.diagnostics.estimated_error:.1e}", mean


def glass_rows():
    """Rows for GLASS_HEAD: two surfaces from the light's view against all of them, traced."""
    for name in SCENES:
        scene, texels = _caster_scene(name)
        seconds, answer = timed(lambda s=scene, t=texels: solve(s, t, Settings(tolerance=1e-2)), 1)
        true = answer.images[0][..., 0]
        yield name, "all surfaces, traced", f"{seconds:.2f}", "100 %", "0"
        for grid in (128, 512):
            settings = Settings("caustic_map", grid=grid)
            seconds, answer = timed(lambda s=scene, t=texels, how=settings: solve(s, t, how), 1)
            image = answer.images[0][..., 0]
            share = f"{100 * image.sum() / true.sum():.0f} %"
            yield name, f"caustic map, {grid}", f"{seconds:.2f}", share, _judged(image, true)[0]
