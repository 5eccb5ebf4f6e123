"""What workers take and bring: memory stated and measured, and the pool's animation by one and by two.

`bench_workers.py memory` bakes a frame of each sample scene, and of the pool at other resolutions and tolerances, and
compares the peak of the worker with what the panel states. `bench_workers.py speed [FRAMES]` bakes the pool by one
worker and by two, in turn, three times each, and gives the medians by the clock; the machine has to be quiet for that.
Writes docs/workers_tables.md, of which each keeps the other's part.
"""

import statistics
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "workers_tables.md"
POOLS = ((512, 1e-2), (1024, 1e-2), (2048, 1e-2), (512, 1e-3), (256, 1e-1))
CASES = [("pool", *pair) for pair in POOLS] + [(n, 512, 1e-2) for n in ("ocean", "lagoon", "glass", "mirror_room")]
CASES += [("ocean", 1024, 1e-2), ("lagoon", 256, 1e-2), ("glass", 256, 1e-2)]
REPEATS = 3


def watched(peaks):
    """A Pool that notes the peaks of its workers' memory [bytes] before they end."""
    from dapple.operators.bake.pool import Pool

    class Watched(Pool):
        def close(self):
            for worker in self._workers:
                lines = Path(f"/proc/{worker._process.pid}/status").read_text().splitlines()
                peaks.extend(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
            super().close()

    return Watched


def bake(scene, folder, **changes):
    """Bake, with changes to the settings or else the request; returns seconds by the clock and peaks of memory."""
    import bpy

    from dapple.operators.bake import bake as module

    request, peaks = replace(module.request_from_scene(scene), out=Path(folder)), []
    own = {key: changes.pop(key) for key in list(changes) if hasattr(request, key)}
    request = replace(request, settings=replace(request.settings, **changes), **own)
    module.Pool = watched(peaks)
    start = time.monotonic()
    for _ in module.bake(bpy.context, request):
        pass
    return time.monotonic() - start, peaks


def memory():
    """Rows: scene, resolution, tolerance, stated and measured megabytes of a worker, and their ratio."""
    import bpy

    from dapple.operators.bake.forecast import forecast

    for name, resolution, tolerance in CASES:
        bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / f"{name}.blend"))
        scene = bpy.context.scene
        scene.dapple.resolution, scene.dapple.tolerance = resolution, tolerance
        bpy.context.view_layer.update()
        _, stated = forecast(scene, bpy.context.view_layer)
        with tempfile.TemporaryDirectory() as folder:
            _, (peak, *_) = bake(scene, folder, frames=(scene.frame_start,))
        yield name, resolution, f"{tolerance:g}", f"{stated / 1e6:.0f}", f"{peak / 1e6:.0f}", f"{stated / peak:.2f}"


def speed(frames):
    """Rows: workers, frames, median seconds by the clock, times the speed of one."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "sample_blends" / "pool.blend"))
    scene, taken = bpy.context.scene, {1: [], 2: []}
    for _ in range(REPEATS):
        for workers, seconds in taken.items():
            with tempfile.TemporaryDirectory() as folder:
                seconds.append(bake(scene, folder, frames=tuple(range(1, frames + 1)), workers=workers)[0])
    one = statistics.median(taken[1])
    for workers, seconds in taken.items():
        median = statistics.median(seconds)
        yield workers, frames, f"{median:.1f}", f"{min(seconds):.1f} to {max(seconds):.1f}", f"{one / median:.2f}"


HEADS = {
    "memory": ("scene", "resolution", "tolerance", "stated [MB]", "measured [MB]", "stated / measured"),
    "speed": ("workers", "frames", "median [s]", "from and to [s]", "times as fast as one"),
}


def main(what, *numbers):
    import bpy

    import dapple
    from dapple.operators.bake.memory import cores
    from dapple.tests.bench.bench_stages import machine

    bpy.ops.wm.read_factory_settings(use_empty=True)
    dapple.register()
    rows = memory() if what == "memory" else speed(*map(int, numbers or (24,)))
    lines = ["| " + " | ".join(HEADS[what]) + " |", "|" + "---|" * len(HEADS[what])]
    for row in rows:
        lines.append("| " + " | ".join(map(str, row)) + " |")
        print(lines[-1], flush=True)
    about = machine().replace("one core", f"{cores()} cores")
    measured = f"Measured on {time.strftime('%Y-%m-%d')} by `bench_workers.py {what}`: {about}."
    head = f"## {what.capitalize()}\n\n{measured}\n\n"
    parts = dict.fromkeys(HEADS, "")
    if PAGE.exists():
        for part in PAGE.read_text().split("## ")[1:]:
            parts[part.split("\n")[0].lower()] = "## " + part.rstrip() + "\n"
    parts[what] = head + "\n".join(lines) + "\n"
    PAGE.write_text("# Workers, measured\n\n" + "\n".join(part for part in parts.values() if part))


if __name__ == "__main__":
    import runpy

    runpy.run_path(str(ROOT / "tests" / "conftest.py"))
    main(*sys.argv[1:])
