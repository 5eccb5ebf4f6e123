"""What the sources claim of their methods, measured here: the tables of docs/sources.md.

Run as `.venv/bin/python tests/bench/bench_sources.py`; it pins itself to one core, prints the tables as it goes and
writes them to docs/sources_tables.md. Times are CPU seconds of this process, warm. The comparators are written in numpy
as Dapple's own methods are, and share what is not their own: the same look for triangles, the same light of a path.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).resolve().parent))

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_sources.py`"


def tables():
    """{title: (head, rows)} of all tables; rows are functions."""
    from bench import source_maps as maps
    from bench import source_water as water

    return {
        "The conic walk: paths at 64 x 64 points, 33 thousand triangles": (water.MANIFOLD_HEAD, water.manifold_rows),
        "The conic walk: triangles, to the first root": (water.TRIANGLE_HEAD, water.triangle_rows),
        "The conic walk: photon maps at 128 x 128 texels, waves a third as high as the pool's": (
            water.PHOTON_HEAD,
            water.photon_rows,
        ),
        "The caustics volume: photons over casters": (maps.PHOTON_HEAD, maps.photon_rows),
        "The caustics volume: geometry buffers, nearest and farthest, at 128 x 128 texels": (
            maps.BUFFER_HEAD,
            maps.buffer_rows,
        ),
        "The caustics volume: surfaces that light meets": (maps.SURFACE_HEAD, maps.surface_rows),
        "Caustics mapping: look-ups": (maps.LOOK_UP_HEAD, maps.look_up_rows),
        "Caustics mapping: grids at 256 x 256 texels": (maps.GRID_HEAD, maps.grid_rows),
        "Caustics mapping: glass by two surfaces": (maps.GLASS_HEAD, maps.glass_rows),
    }


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[-1]})
    load_dapple()
    table = Table()
    for title, (head, rows) in tables().items():
        table.lines += ["", f"## {title}"]
        print(f"\n{title}")
        table.head(*head)
        for row in rows():
            table.add(*row)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "sources_tables.md").write_text(text + "\n".join(table.lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
