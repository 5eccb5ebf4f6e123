"""Accuracy and CPU time of all methods against converged references: the tables of docs/accuracy.md, and its figure.

Run as `.venv/bin/python tests/bench/bench_accuracy.py`; it pins itself to one core, makes the references that are not
in tests/bench/references yet, prints the tables as it goes and writes docs/accuracy_tables.md and docs/images/cost.png.
"""

from __future__ import annotations

import os
import sys
import time

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_accuracy.py`"


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    from bench.accuracy_cases import HEAD, TABLES

    table = Table()
    for title, cases in TABLES.items():
        table.lines += ["", f"## {title}"]
        print(f"\n{title}")
        table.head(*HEAD)
        for case in cases():
            table.add(*case.row())
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "accuracy_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
