"""Light over glass, mirrors and water against Mitsuba 3: the tables and pictures of docs/casters.md.

Needs `mitsuba` from PyPI beside what Dapple needs, and LLVM 16 or newer where the processor has
AVX-512 (DRJIT_LIBLLVM_PATH names its library). Run as `python tests/bench/bench_casters.py`; it uses one thread, makes
the references that are not in tests/bench/references yet, prints the tables as it goes and writes
docs/casters_tables.md and docs/images/casters_*.png. With names of scenes as arguments it measures and draws these
only, and prints their tables.
"""

from __future__ import annotations

import platform
import sys
import time
from functools import partial
from itertools import chain
from pathlib import Path

from bench_stages import ROOT, Table, load_dapple

COMMAND = "`python tests/bench/bench_casters.py`"
ASKED = (1e-1, 1e-2)
# Where ptracer's camera stands, the side of what it looks at, and how high that lies [m]; the lagoon's is under water.
_VIEWS = {"glass": ((0, 0, 20.0), 1.5), "mirror_room": ((0, 0, 20.0), 3.2), "lagoon": ((2.5, -3.5, -0.2), 2.0, -1.2)}
_DRAWN = "ring", "stone", "glass.blend", "mirror_room.blend"  # the pictures of docs/casters.md


def cases(names):
    """All that is measured, or what is named."""
    import waves
    from bench import caster_scenes as scenes
    from bench.caster_cases import Case
    from bench.mitsuba_camera import View
    from bench.sample_scenes import read

    makers = {"pool": (lambda: waves.pool(quads=128), View((0, 0, 1.2), 4.0))}
    makers |= {make.__name__: (make, View((0, 0, 20.0), 1.0)) for make in scenes.SMALL}
    makers |= {f"{name}.blend": (partial(read, name), View(*_VIEWS[name])) for name in scenes.SAMPLES}
    for name, (make, view) in makers.items():
        if not names or name in names:
            yield Case(name, make(), view)


def tables(table, names):
    """Add all tables to a Table, or of the scenes of some names, and draw what all are made of."""
    from bench import caster_checks
    from bench.caster_cases import ERROR_HEAD, TIME_HEAD
    from bench.caster_pictures import draw

    def begin(title, head, rows):
        table.lines += ["", f"## {title}"]
        print(f"\n{title}")
        table.head(*head)
        for row in rows:
            table.add(*row)

    measured = list(cases(names))
    if not names:
        begin("The reference against closed forms", caster_checks.HEAD, caster_checks.rows())
    errors = (case.error_rows(tolerance) for case in measured for tolerance in ASKED)
    begin("Errors of the maps", ERROR_HEAD, chain.from_iterable(errors))
    begin("CPU seconds to an error of 1e-2", TIME_HEAD, (case.time_row() for case in measured))
    walked = (case.error_rows(1e-2, "conic_walk") for case in measured if case.name == "lagoon.blend")
    begin("One interface: the conic walk", ERROR_HEAD, chain.from_iterable(walked))
    for case in (case for case in measured if case.name in _DRAWN):
        draw(case, ROOT / "docs" / "images" / f"casters_{case.name.removesuffix('.blend')}.png")


def machine():
    """One line on processor and versions."""
    import mitsuba
    import numpy as np

    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    cpu = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, Mitsuba {mitsuba.__version__}"
    return f"{cpu}, one thread; {versions}, {mitsuba.variant()}"


def main():
    import drjit
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    drjit.set_thread_count(1)
    load_dapple(register=False)  # another process reads the scenes
    table = Table()
    tables(table, sys.argv[1:])
    if sys.argv[1:]:
        return
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "casters_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
