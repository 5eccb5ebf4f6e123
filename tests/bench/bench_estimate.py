"""How honest the estimates are and how good the planner's choices, on 30 ponds by chance: docs/estimate_tables.md.

Run as `.venv/bin/python tests/bench/bench_estimate.py`. The truth is that of the true waves, by `reference_waves.py`,
which shares no code with the kernels; ponds, meshes, suns and resolutions are those of `estimate_ponds.py`, on which no
constant was fitted.
"""

from __future__ import annotations

import os
import sys
import time
from functools import partial

from bench_stages import ROOT, Table, load_dapple, machine

COMMAND = "`.venv/bin/python tests/bench/bench_estimate.py`"
TOLERANCES = 5e-2, 1e-2, 1e-3
HEAD = (
    "seed", "triangles", "texels", "contrast", "asked", "choice", "without", "CPU [s]", "planning [s]", "true error",
    "estimate", "true / estimate", "complete [s]", "best that meets it", "choice / best",
)  # fmt: skip
COMPARED = (1e-2,)  # at which all that could have been chosen is solved as well
REPEATS = 2


def rows(tolerance):
    """A row of HEAD for each pond."""
    from bench.accuracy_cases import timed
    from bench.estimate_ponds import SEEDS, by_chance, water_of
    from bench.reference_files import of_waves

    from dapple.kernels.anchor import Kept
    from dapple.kernels.maps.texels import rasterise
    from dapple.kernels.methods import prepare, solve
    from dapple.kernels.scene import Settings

    for seed in SEEDS:
        pond, quads, resolution = by_chance(seed)
        truth, scene = of_waves(pond, resolution), pond.scene(water_of(pond, quads))
        own = [rasterise(scene.receivers[0], resolution)]
        kept = Kept(prepare(scene, own, Settings(tolerance=tolerance)))
        found = {}
        for name, how in ways(tolerance).items():
            seconds, answer = timed(partial(solve, scene, own, how, kept), REPEATS)
            found[name] = seconds, truth.judge(answer.images[0][..., 0])[0], answer.diagnostics
        seconds, error, work = found.pop("auto")
        fit = {name: of[0] for name, of in found.items() if of[1] <= tolerance}
        best = min(fit, key=fit.get, default="none")
        estimate = work.estimated_error
        yield (
            seed, 2 * quads**2, resolution, (truth.image.std() / truth.image.mean()).round(3), f"{tolerance:g}",
            work.plan["choice"], ", ".join(work.plan["without"]), f"{seconds:.4f}", f"{work.seconds['plan']:.4f}",
            f"{error:.1e}", f"{estimate:.1e}", f"{error / estimate:.2f}", f"{found['complete'][0]:.4f}", best,
            f"{seconds / fit[best]:.2f}" if fit else "-",
        )  # fmt: skip


def ways(tolerance):
    """All that could have been chosen, by name."""
    from dapple.kernels.scene import Settings

    found = {"auto": Settings("auto", tolerance), "complete": Settings("photon_splat", tolerance)}
    if tolerance in COMPARED:
        found["flat"] = Settings("flat", tolerance)
        found["caustic map"] = Settings("caustic_map", tolerance)
        found["mesh"] = Settings("photon_splat", tolerance, without=("reconstruction",))
        found["mesh, no disc"] = Settings("photon_splat", tolerance, without=("reconstruction", "disc"))
        found["smooth, no disc"] = Settings("photon_splat", tolerance, without=("disc",))
    return found


def summary(table):
    """Sentences on all rows, (cells by HEAD)."""
    number = dict(zip(HEAD, range(len(HEAD)), strict=True))
    ratios = [float(row[number["true / estimate"]]) for row in table]
    over = sum(float(row[number["true error"]]) > float(row[number["asked"]]) for row in table)
    against = [float(row[-1]) for row in table if row[-1] != "-"]
    within = sum(0.5 <= ratio <= 2 for ratio in ratios)
    near = sum(ratio <= 1.3 for ratio in against)
    return (
        f"Within a factor of 2: {within} of {len(table)}. Above the tolerance: {over}. Within 1.3 times the time of "
        f"the best that meets the tolerance, planning included: {near} of {len(against)}."
    )


def main():
    os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    load_dapple()
    table = Table()
    for tolerance in TOLERANCES:
        table.lines += ["", f"## Asked for {tolerance:g}"]
        table.head(*HEAD)
        known = []
        for row in rows(tolerance):
            known.append(row)
            table.add(*row)
        print(summary(known))
        table.lines += ["", summary(known)]
    text = f"Measured on {time.strftime('%Y-%m-%d')} by {COMMAND}: {machine()}.\n"
    (ROOT / "docs" / "estimate_tables.md").write_text(text + "\n".join(table.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
