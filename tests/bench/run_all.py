"""Make the tables and charts of docs anew: each by its own command, in two lanes, one core to each.

Run as `.venv/bin/python tests/bench/run_all.py [NAME ...]` on a quiet Linux machine of two cores, with `mitsuba` from
PyPI; NAMEs are those of LANES, all without. It takes about 25 minutes. What each prints is kept in a folder that is
named at the end, with how long each took and which failed; the exit code says whether any did.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LANES = (
    {"accuracy": "bench/bench_accuracy.py", "disc": "bench/bench_disc.py", "speed": "bench/bench_stages.py"},
    {
        "charts": "figures/draw_charts.py",
        "surface": "bench/bench_surface.py",
        "overhangs": "bench/bench_overhangs.py",
        "sources": "bench/bench_sources.py",
    },
)


def run(name, script, core, folder):
    """Run a script of tests on a core; returns a line on its end, and whether it went well."""
    start = time.monotonic()
    command = ["taskset", "-c", str(core), sys.executable, str(ROOT / "tests" / script)]
    with open(folder / f"{name}.txt", "w", encoding="utf-8") as said:
        code = subprocess.run(command, cwd=ROOT, stdout=said, stderr=subprocess.STDOUT).returncode
    line = f"{name}: {time.monotonic() - start:.0f} s{'' if code == 0 else f', FAILED with {code}'}"
    print(line, flush=True)
    return line, code == 0


def main(names):
    """Run what is named, or all; returns the exit code."""
    unknown = sorted(set(names) - {name for lane in LANES for name in lane})
    if unknown:
        print(f"there is no {unknown[0]}; name some of {', '.join(name for lane in LANES for name in lane)}")
        return 2
    folder = Path(tempfile.mkdtemp(prefix="dapple-tables-"))
    cores = sorted(os.sched_getaffinity(0))

    def follow(number):
        chosen = {name: script for name, script in LANES[number].items() if not names or name in names}
        return [run(name, script, cores[number % len(cores)], folder) for name, script in chosen.items()]

    with ThreadPoolExecutor(len(LANES)) as lanes:
        ends = [end for lane in lanes.map(follow, range(len(LANES))) for end in lane]
    (folder / "summary.txt").write_text("\n".join(line for line, _ in ends) + "\n", encoding="utf-8")
    print(f"What they printed is in {folder}")
    return 0 if all(well for _, well in ends) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
