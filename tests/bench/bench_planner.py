"""Is what `auto` takes worth its time? Thirty waters by chance, every rung on each: docs/planner_tables.md.

Run as `.venv/bin/python tests/bench/bench_planner.py`; it prints the table as it goes and takes about twenty minutes.
Numbers of seeds as arguments measure these only, and write nothing. Waves, depth and sun are drawn as for accuracy; so
are the height of the waves, from hardly any to all, the resolution, and whether the sun has its disc. Errors are
against the chart's reference; on the front count our own rungs only.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from bench_stages import ROOT, Table, load_dapple, machine

SEEDS = range(1, 31)
COMMAND = "`.venv/bin/python tests/bench/bench_planner.py`"
HEAD = (
    "seed", "depth [m]", "wave height", "texels", "sun", "asked", "auto took", "CPU [s]", "over the front", "error",
    "own estimate", "estimate over error", "reference's error",
)  # fmt: skip
ENOUGH = 1.3


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
            yield (
                seed, f"{pond.depth:.2f}", f"{height:.2f}", f"{resolution}²", "0.53°" if pond.angle else "sharp",
                f"{row.label}: {row.asked:g}", row.method, f"{row.seconds:.3f}", f"{row.over_front:.2f}",
                f"{row.error:.1e}", f"{estimate:.1e}", f"{estimate / max(row.error, chart.reference.error):.2g}",
                f"{chart.reference.error:.0e}",
            )  # fmt: skip


def summary(found):
    """Sentences on all rows."""
    over, ratio = (np.array([float(row[HEAD.index(name)]) for row in found]) for name in HEAD[8:12:3])
    error = np.array([float(row[HEAD.index("error")]) for row in found])
    asked = np.array([float(row[HEAD.index("asked")].split(": ")[1]) for row in found])
    yield f"On the front or within {ENOUGH} of it in time: {np.mean(over <= ENOUGH):.0%} of {len(found)} choices."
    seconds, slow = np.array([float(row[HEAD.index("CPU [s]")]) for row in found]), over > ENOUGH
    more = 1e3 * seconds * (1 - 1 / np.maximum(over, 1))
    if slow.any():
        few, most = 1e3 * seconds[slow].min(), 1e3 * seconds[slow].max()
        yield f"Elsewhere it is {np.median(more[slow]):.0f} ms above in the median, of {few:.0f} to {most:.0f} ms."
    yield f"On the front, within {ENOUGH} of it, or no more than 20 ms above: {np.mean(~slow | (more <= 20)):.0%}."
    yield f"Error within what was asked: {np.mean(error <= asked):.0%}."
    yield f"Estimate within a factor of 2 of the error: {np.mean((ratio >= 0.5) & (ratio <= 2)):.0%}."


def _last(steps):
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def main():
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
        text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n\n" + "\n".join(said) + "\n\n"
        (ROOT / "docs" / "planner_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
