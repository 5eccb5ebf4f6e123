"""Photons and rays a second of processor time, on one core: the table of docs/speed.md.

A photon is one path from where it sets out to its end: a receiver, nothing at all, or what ends it by the rules. Over
water it meets one interface; over casters it is counted with all surfaces that it meets. Points that meet no caster are
followed and not counted. Landing, which texel and with which flux, is part of it, and so is drawing the point.

Run as `.venv/bin/python tests/bench/bench_tracer.py`; it pins itself to a core, prints the table as it goes and writes
it to docs/tracer_tables.md. Rates are those of the median of REPEATS warm runs in CPU seconds of this process.
"""

from __future__ import annotations

import os
import time
from dataclasses import replace
from itertools import chain

from bench_stages import ROOT, Table, load_dapple, machine, median

COMMAND = "`.venv/bin/python tests/bench/bench_tracer.py`"
_POINTS, _MANY = 3e5, 2e6
_RESOLUTION = 512


HEAD = "scene", "photons", "photons [M/s]", "rays a photon", "rays [M/s]", "of the time, in the ray library"


def water_rows():
    """Cells of HEAD for one interface."""
    from waves import pool

    scene = pool(quads=256)
    uneven = replace(scene, receivers=(_uneven(scene.receivers[0]),))
    yield "water over a flat floor", "landed in closed form", *_over_water(scene)
    yield "water over an uneven floor", "landed by rays", *_over_water(uneven)


def _uneven(receiver):
    """The receiver with bumps: a grid of 64 by 64 quads."""
    import numpy as np
    from waves import grid

    from dapple.kernels.scene import Receiver

    x, y, triangles = grid(64, np.ptp(receiver.positions[:, 0]))
    z = receiver.positions[0, 2] + 0.05 * np.sin(5 * x) * np.cos(4 * y)
    uv = np.stack([x, y], 1) / np.ptp(x) + 0.5
    return Receiver(receiver.name, np.stack([x, y, z], 1), triangles, uv[triangles])


def _over_water(scene):
    """Cells of HEAD after the second, of points over the water of a Scene."""
    import numpy as np

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Settings
    from dapple.kernels.splat import photon_splat

    own = [rasterise(receiver, _RESOLUTION) for receiver in scene.receivers]
    (lit,) = photon_splat._over_water(scene, own, Settings(surface="mesh", points=True))
    return rates(lambda: lit.throw(_MANY, np.random.default_rng(0))[3])


def caster_rows():
    """Cells of HEAD over casters."""
    from bench.caster_scenes import ball
    from bench.sample_scenes import read_here

    through, mirrored = (0b111, "in and out again"), (0b1, "off mirrors alone")
    for name, scene, (word, what) in (
        ("a glass ball over a table", ball(), through),
        ("glass.blend", read_here("glass"), through),
        ("mirror_room.blend", read_here("mirror_room"), mirrored),
    ):
        cast = _cast(scene)
        yield name, what, *_followed(cast, word)
        yield name, "all branches", *_followed(cast, None)


def _cast(scene):
    """The Cast of the first light of a Scene, without a disc."""
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Settings
    from dapple.kernels.trace.cast import over_casters

    light = scene.lights[0]
    light = replace(light, angle=0.0) if hasattr(light, "angle") else light
    own = [rasterise(receiver, _RESOLUTION) for receiver in scene.receivers]
    return over_casters(replace(scene, lights=(light,)), own, Settings())[0]


def _followed(cast, word):
    """Cells of HEAD after the second, of points of a Cast along the code `word`, or along all."""
    import numpy as np

    from dapple.kernels.trace.codes import Codes
    from dapple.kernels.trace.entry import evenly, points

    codes = None if word is None else Codes([word])

    def run():
        photons = 0
        for _, _, m, area in points(cast.water, evenly(cast.water, _POINTS), cast.entry.place, 0):
            rays, met = cast.start(m)
            for ended, end in cast.follower.ends(rays, codes):
                landed, arrives = cast.book(cast.ways(ended, end, codes), np.take(area * met, ended.photon))
                cast.bins.add(cast.arrivals.texel(landed), arrives)
                photons += len(end)
        cast.bins.take()
        return photons

    return rates(run)


def rates(run):
    """Cells of HEAD after the second: run() follows photons and returns how many."""
    seconds, photons = median(run)
    rays, within = _rays_of(run)
    return (
        f"{photons / seconds / 1e6:.2f}", f"{rays / photons:.2f}", f"{rays / seconds / 1e6:.2f}",
        f"{within:.0%}",
    )  # fmt: skip


def _rays_of(run):
    """How many rays run() casts, and which part of its CPU seconds goes to the ray library."""
    from dapple.kernels.rays import Tracer

    first, rays, inside = Tracer.first, 0, 0.0

    def counted(self, origins, directions):
        nonlocal rays, inside
        start = time.process_time()
        found = first(self, origins, directions)
        inside += time.process_time() - start
        rays += len(found)
        return found

    Tracer.first = counted
    try:
        start = time.process_time()
        run()
        return rays, inside / (time.process_time() - start)
    finally:
        Tracer.first = first


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    table = Table()
    table.head(*HEAD)
    for row in chain(water_rows(), caster_rows()):
        table.add(*row)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "tracer_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    main()
