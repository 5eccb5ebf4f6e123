"""Is what `auto` takes worth its time? Thirty waters by chance, every rung on each: docs/planner_tables.md.

Run as `.venv/bin/python tests/bench/bench_planner.py`; it prints the table as it goes and takes about twenty minutes.
Numbers of seeds as arguments measure these only, and write nothing. Waves, depth and sun are drawn as for accuracy; so
are the height of the waves, from hardly any to all, the resolution, and whether the sun has its disc. Errors are
against the chart's reference; on the front count our own rungs only.
"""

from __future__ import annotations

import os
import sys
import time

import numpy as np
from bench_stages import ROOT, Table, load_dapple, machine

SEEDS = range(1, 31)
COMMAND = "`.venv/bin/python tests/bench/bench_planner.py`"
HEAD = (
    "seed", "depth [m]", "wave height", "texels", "sun", "asked", "auto took", "CPU [s]", "planning [s]",
    "quickest as good", "over the front", "error", "own estimate", "estimate over error", "reference's error",
)  # fmt: skip
ENOUGH, TURNS = 1.3, 7


def drawn(seed):
    """(Pond, share of its waves' height, resolution) of a seed."""
    from dataclasses import replace

    from bench.accuracy_ponds import drawn as pond_of

    rng = np.random.default_rng([seed, 7])
    pond, height = pond_of(seed), float(np.exp(rng.uniform(np.log(0.02), 0.0)))
    waves = replace(pond.waves, amplitude=height * pond.waves.amplitude)
    pond = replace(pond, waves=waves)
    if rng.random() < 0.5:
        pond = pond.with_disc()
    return pond, height, int(rng.choice([64, 128, 192]))


def rows(seed):
    """Cells of HEAD, one row for each preset."""
    from bench.accuracy_meshes import regular

    from dapple.kernels.chart.chart import build
    from dapple.kernels.chart.ladder import AUTO
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.scene import Settings

    pond, height, resolution = drawn(seed)
    scene = pond.scene(regular(pond))
    texels = (rasterise(scene.receivers[0], resolution),)
    chart = _last(build(scene, texels, Settings(resolution=resolution)))
    for row in chart.rows:
        if row.rung == AUTO:
            estimate = np.nan if row.estimated is None else row.estimated
            seconds, planning, name, over = against(scene, texels, resolution, row, chart.rows)
            yield (
                seed, f"{pond.depth:.2f}", f"{height:.2f}", f"{resolution}²", "0.53°" if pond.angle else "sharp",
                f"{row.label}: {row.asked:g}", row.method, f"{seconds:.4f}", f"{planning:.4f}", name, f"{over:.2f}",
                f"{row.error:.1e}", f"{estimate:.1e}", f"{estimate / max(row.error, chart.reference.error):.2g}",
                f"{chart.reference.error:.0e}",
            )  # fmt: skip


def against(scene, texels, resolution, auto, rows):
    """CPU seconds of a row of auto's, of its planning, what is the quickest of our other rows that is as good, and how
    many times as long auto takes as that: the two take turns, since the machine is not always as quick."""
    from dapple.kernels.anchor import Kept
    from dapple.kernels.chart.ladder import rungs
    from dapple.kernels.methods import prepare, solve
    from dapple.kernels.plan.planner import planned
    from dapple.kernels.scene import Settings

    base = Settings(resolution=resolution)
    known = {(rung.name, label): own for rung in rungs(scene, base) for label, own in rung.settings(base)}
    as_good = [row for row in rows if not row.peer and row.rung != auto.rung and row.error <= auto.error]
    best = min(as_good, key=lambda row: row.seconds, default=None)
    own = known[auto.rung, auto.label]
    kept = Kept(prepare(scene, texels, own))
    runs = [lambda: solve(scene, texels, own, kept)]
    runs.append(lambda: planned(scene, texels, own, kept.anchor.smoothing, kept.anchor.plan))
    if best is not None:
        other = known[best.rung, best.label]
        others = Kept(prepare(scene, texels, other))
        runs.append(lambda: solve(scene, texels, other, others))
    seconds = np.array([[_timed(run) for run in runs] for _ in range(TURNS)])[1:]
    over = np.median(seconds[:, 0] / seconds[:, -1]) if best is not None else 0.0
    name = f"{best.rung}, {best.label}" if best is not None else "none"
    return np.median(seconds[:, 0]), np.median(seconds[:, 1]), name, over


def _timed(run):
    start = time.process_time()
    run()
    return time.process_time() - start


def summary(found):
    """Sentences on all rows."""
    names = "over the front", "estimate over error", "error", "planning [s]", "CPU [s]"
    over, ratio, error, planning, whole = (np.array([float(row[HEAD.index(name)]) for row in found]) for name in names)
    asked = np.array([float(row[HEAD.index("asked")].split(": ")[1]) for row in found])
    yield f"On the front or within {ENOUGH} of it in time: {np.mean(over <= ENOUGH):.0%} of {len(found)} choices."
    alone = over * (1 - planning / whole)
    yield f"The same of what was chosen alone, without its planning: {np.mean(alone <= ENOUGH):.0%}."
    yield f"Planning takes {1e3 * np.median(planning):.1f} ms in the median, {1e3 * planning.max():.1f} at most."
    yield f"Error within what was asked: {np.mean(error <= asked):.0%}."
    yield f"Estimate within a factor of 2 of the error: {np.mean((ratio >= 0.5) & (ratio <= 2)):.0%}."


def _last(steps):
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    seeds, table, found = [int(word) for word in sys.argv[1:]], Table(), []
    table.head(*HEAD)
    for seed in seeds or SEEDS:
        for row in rows(seed):
            table.add(*row)
            found.append(row)
    said = list(summary(found))
    print("\n".join(said))
    if not seeds:
        text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n\n"
        text += "\n".join(f"- {sentence}" for sentence in said) + "\n\n"
        (ROOT / "docs" / "planner_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
