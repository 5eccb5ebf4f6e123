"""Seconds per stage of a bake of the pool, on one core: the table of docs/speed.md.

Run as `.venv/bin/python tests/bench/bench_stages.py`; it pins itself to one core, prints the tables as it goes and
writes them to docs/speed_tables.md. Times are CPU seconds of this process, warm, the median of REPEATS.
"""

from __future__ import annotations

import importlib.util
import json
import os
import platform
import statistics
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"
ROOT = Path(__file__).resolve().parents[2]
REPEATS = 5
QUADS = {"33k": 128, "131k": 256, "524k": 512}
RESOLUTIONS = (256, 512, 1024)
COMMAND = "`.venv/bin/python tests/bench/bench_stages.py`"


def load_dapple(register=True):
    """Import the working tree as the package `dapple`, with the add-on registered where `register`, which brings
    Blender into this process, and find the tests' waves."""
    spec = importlib.util.spec_from_file_location(
        "dapple", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    sys.modules["dapple"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["dapple"])
    if register:
        sys.modules["dapple"].register()
    sys.path.insert(0, str(ROOT / "tests"))


def median(run, repeats=REPEATS):
    """Median CPU seconds of run(), which is called once more before, and what it returned last."""
    run()
    seconds = []
    for _ in range(repeats):
        start = time.process_time()
        result = run()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds), result


def blender_pool(quads):
    """The depsgraph of a new Blender scene: the pool's waves in the vertices of a smooth grid, a floor, a sun."""
    import bpy
    from waves import five_sines, grid

    bpy.ops.wm.read_factory_settings(use_empty=True)
    x, y, _ = grid(quads, 4.8)
    height, _, _ = five_sines(x, y)
    corner = [row * (quads + 1) + column for row in range(quads) for column in range(quads)]
    mesh = bpy.data.meshes.new("Water")
    mesh.from_pydata(list(zip(x, y, height + 1.5)), [], [(k, k + 1, k + quads + 2, k + quads + 1) for k in corner])
    mesh.shade_smooth()
    bpy.context.collection.objects.link(bpy.data.objects.new("Water", mesh))
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.name = "Floor"
    bpy.ops.object.light_add(type="SUN")
    return bpy.context.evaluated_depsgraph_get()


def extraction(quads):
    """Seconds of reading a frame from Blender: the first, with its adjacency, and a later one."""
    from dapple.operators.read.extract import read_scene
    from dapple.operators.read.mesh_arrays import TopologyCache

    depsgraph, topology = blender_pool(quads), TopologyCache()
    first, _ = median(lambda: read_scene(depsgraph, ("Water",), ("Floor",), TopologyCache()))
    later, _ = median(lambda: read_scene(depsgraph, ("Water",), ("Floor",), topology))
    return first, later


def stages(resolution, quads):
    """Seconds on a floor under water, of texels, beams, points, the walk and writing, and what the solvers say."""
    from waves import pool

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import solve
    from dapple.kernels.scene import Settings
    from dapple.operators.maps.write import write_exr

    scene = pool(quads=quads)
    raster, own = median(lambda: rasterise(scene.receivers[0], resolution), 1)
    mesh = Settings(surface="mesh")
    beams, splat = median(lambda: solve(scene, [own], mesh))
    points, scatter = median(lambda: solve(scene, [own], replace(mesh, points=True)), 3)
    first = replace(mesh, method="conic_walk", first_root=True)
    walk, by_walk = median(lambda: solve(scene, [own], first), 3)
    with tempfile.TemporaryDirectory() as folder:
        write, _ = median(lambda: write_exr(Path(folder) / "map.exr", splat.images[0]), 3)
    return raster, beams, splat.diagnostics, points, scatter.diagnostics, walk, by_walk.diagnostics, write


def sample_pool():
    """Median seconds per stage, and the estimated error, of frame 2 of sample_blends/pool.blend: three receivers, a
    ring, a coping."""
    import bpy

    from dapple.operators.bake.bake import bake, request_from_scene

    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / "pool.blend"))
    runs = []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as folder:
            request = request_from_scene(bpy.context.scene, frames=(1, 2), out=folder)
            list(bake(bpy.context, request))
            entry = json.loads((Path(folder) / "bake.json").read_text())["frames"]["2"]
        runs.append(entry["seconds"])
    stage = {name: statistics.median(run[name] for run in runs) for name in runs[0]}
    return stage, entry["estimated_error"]


def rates():
    """Nanoseconds per triangle step, planar and traced photons per second, from the kernels' own loops."""
    import numpy as np
    from waves import pool

    from dapple.kernels.lit_water import light_water
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.rays import Tracer, soup
    from dapple.kernels.splat.lander import Lander
    from dapple.kernels.splat.landing import Plane, Rays
    from dapple.kernels.splat.photons import batches
    from dapple.kernels.splat.plane import one_plane
    from dapple.kernels.splat.silhouettes import Silhouettes
    from dapple.kernels.walk.lit_surface import Surface
    from dapple.kernels.walk.walkers import Walk

    scene = pool(quads=512)
    own = rasterise(scene.receivers[0], 512)
    lit = light_water(scene.water, scene.lights[0])
    plane = Plane(own, scene.eta, lit, one_plane(scene, [own]))
    unshadowed = np.zeros(len(scene.water.triangles), bool)
    solids = soup(scene.receivers)
    around = Tracer(*solids), Silhouettes(*solids), None
    lander = Lander(scene.receivers, [own], *around, lit.source, scene.eta, scene.sigma_a)
    rays = Rays(lander, 1, own.resolution, lit, unshadowed)

    def throw(landing, photons):
        used = 0
        for triangles, points, flux in batches(lit, photons, np.random.default_rng(0)):
            landing.add(triangles, points, flux)
            used += len(triangles) * points.shape[1]
        landing.take()
        return used

    yield "photons onto a plane [M/s]", *rate(lambda: throw(plane, 8e6), 1e-6)
    yield "photons traced by rays [M/s]", *rate(lambda: throw(rays, 4e6), 1e-6)
    surface = Surface(lit, scene.water.twins)
    first = Tracer(scene.water.positions, scene.water.triangles).first(
        own.positions, np.broadcast_to(lit.frame[2], own.positions.shape)
    )
    yield "walk [ns per triangle step]", *step_cost(Walk, surface, lit.frame @ own.positions.T, first, scene.eta)


def caster_rates():
    """Points and rays per second over a glass ball on a table and over glass.blend, of which points carry both branches
    at every surface."""
    import numpy as np
    from bench.caster_scenes import ball
    from bench.sample_scenes import read_here

    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Settings
    from dapple.kernels.trace.cast import over_casters

    for name, scene in (("a glass ball", ball()), ("glass.blend", read_here("glass"))):
        sun = replace(scene.lights[0], angle=0.0)
        own = [rasterise(receiver, 512) for receiver in scene.receivers]
        (cast,) = over_casters(replace(scene, lights=(sun,)), own, Settings())

        def rays(cast=cast):
            before = cast.follower.cast
            cast.throw(2e5, np.random.default_rng(0))
            return cast.follower.cast - before

        yield f"points over {name} [M/s]", *rate(lambda cast=cast: cast.throw(2e5, np.random.default_rng(0))[3], 1e-6)
        yield f"rays over {name} [M/s]", *rate(rays, 1e-6)


def rate(run, scale):
    """(median units per second times `scale`, units): run() returns how many it did."""
    seconds, count = median(run)
    return count / seconds * scale, count


def step_cost(walk_class, surface, p, first, eta):
    """(median nanoseconds of a triangle step, steps): the time inside the walk's steps, without starts and roots."""
    costs = []
    for _ in range(REPEATS):
        spent = 0.0

        def timed(method):
            def run(self, *arguments):
                nonlocal spent
                start = time.process_time()
                result = method(self, *arguments)
                spent += time.process_time() - start
                return result

            return run

        names = "_advance", "_follow", "_collect"
        steps = type("Timed", (walk_class,), {name: timed(getattr(walk_class, name)) for name in names})
        walk = steps(surface, p, first, eta).run()
        costs.append(spent / walk.steps * 1e9)
    return statistics.median(costs), walk.steps


def machine():
    """One line on processor and versions."""
    import bpy
    import numpy as np

    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        cpu = next((x.split(":")[1].strip() for x in info.read_text().splitlines() if x.startswith("model name")), cpu)
    return f"{cpu}, one core; Python {platform.python_version()}, numpy {np.__version__}, bpy {bpy.app.version_string}"


class Table:
    """Rows that are printed as they come and kept for the document."""

    def __init__(self):
        self.lines = []

    def add(self, *cells):
        line = "| " + " | ".join(map(str, cells)) + " |"
        self.lines.append(line)
        print(line, flush=True)

    def head(self, *cells):
        self.lines.append("")
        self.add(*cells)
        self.add(*["---"] * len(cells))


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    table = Table()
    table.head("core loop", "median", "units a run")
    for name, value, units in (*rates(), *caster_rates()):
        table.add(name, f"{value:.1f}", f"{units / 1e6:.1f} M")
    table.head("water", "extract, first frame [s]", "extract, later frames [s]")
    for name, quads in QUADS.items():
        table.add(name, *(f"{seconds:.3f}" for seconds in extraction(quads)))
    stage, error = sample_pool()
    table.head("stage of a frame of pool.blend at 512 x 512", "seconds")
    for name, seconds in stage.items():
        table.add(name.replace("solve.", "of that, "), f"{seconds:.3f}")
    table.add("(estimated error)", f"{error:.5f}")
    table.head(
        "resolution", "water", "texels, once [s]", "beams [s]", "error", "points [s]", "photons", "error",
        "first root [s]", "steps a texel", "write [s]",
    )  # fmt: skip
    for resolution in RESOLUTIONS:
        for name, quads in QUADS.items():
            raster, beams, splat, points, scatter, walk, by_walk, write = stages(resolution, quads)
            table.add(
                resolution, name, f"{raster:.2f}", f"{beams:.2f}", f"{splat.estimated_error:.5f}",
                f"{points:.2f}", f"{scatter.paths['photons'] / 1e6:.1f} M", f"{scatter.estimated_error:.4f}",
                f"{walk:.2f}", f"{by_walk.paths['triangle_steps'] / resolution**2:.1f}", f"{write:.3f}",
            )  # fmt: skip
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "speed_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    main()
