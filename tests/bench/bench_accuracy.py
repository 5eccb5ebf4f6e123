"""Accuracy and CPU time of all methods against converged references: the tables of docs/accuracy.md, and its figure.

Run as `.venv/bin/python tests/bench/bench_accuracy.py`; it pins itself to one core, makes the references that are not
in tests/bench/references yet, prints the tables as it goes and writes docs/accuracy_tables.md and docs/images/cost.png.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_accuracy.py`"


def tables(table):
    """Add all tables to a Table."""
    from bench.accuracy_cases import HEAD, TABLES
    from bench.accuracy_cost import PEAK_HEAD, STEP_HEAD, WALK_HEAD, step_rows, walk_rows

    def begin(title, head):
        table.lines += ["", f"## {title}"]
        print(f"\n{title}")
        table.head(*head)

    for title, cases in TABLES.items():
        begin(title, HEAD)
        for case in cases():
            table.add(*case.row())
    begin("Steps of the conic walk to the first root", STEP_HEAD)
    for row in step_rows():
        table.add(*row)
    begin("The conic walk, same mesh", WALK_HEAD)
    for row in walk_rows():
        table.add(*row)
    begin("Two million triangles, same mesh", PEAK_HEAD)
    for name in ("exact coverage", "all roots", "first root"):
        with ProcessPoolExecutor(1, get_context("spawn")) as alone:
            table.add(name, 2_000_000, 512, *alone.submit(two_million, name).result())


def two_million(name):
    """CPU seconds and most memory [GB] of a bake in this process, which is a fresh one."""
    load_dapple(register=False)  # no Blender in the peak
    from bench.accuracy_cost import run

    seconds, _ = run(name, 1000, 512, 1)
    unit = 1e9 if sys.platform == "darwin" else 1e9 / 1024
    return f"{seconds:.2f}", f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit:.2f}"


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    from bench.accuracy_cost import draw, measure_costs

    table = Table()
    tables(table)
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "accuracy_tables.md").write_text(text + "\n".join(table.lines) + "\n")
    draw(measure_costs(), ROOT / "docs" / "images" / "cost.png")


if __name__ == "__main__":
    sys.exit(main())
