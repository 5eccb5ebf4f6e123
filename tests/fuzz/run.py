"""Fuzz kernels and operators and write docs/fuzz.md: .venv/bin/python tests/fuzz/run.py --cases 10000"""

import argparse
import importlib.util
import sys
import time
import traceback
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def load():
    """Make the working tree importable as `dapple`."""
    spec = importlib.util.spec_from_file_location(
        "dapple", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    sys.modules["dapple"] = package = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)


def main():
    """Run half of the cases on each level; returns 1 if one failed."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--cases", type=int, default=10000)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--batch", type=int, default=250, help="cases from one seed")
    asked = words.parse_args()
    load()
    import bpy

    import dapple
    from dapple.tests.fuzz import kernel_cases, operator_cases
    from dapple.tests.fuzz.fuzz import fuzz

    bpy.ops.wm.read_factory_settings(use_empty=True)
    dapple.register()
    text, failed = [], 0
    for name, level in (("Blender files and words", operator_cases), ("Kernels", kernel_cases)):
        start, outcomes, failures, slowest, done = time.process_time(), {}, {}, 0.0, 0
        while done < asked.cases // 2:
            count = min(asked.batch, asked.cases // 2 - done)
            own, wrong, slow = fuzz(level.cases, level.run, count, asked.seed + done)
            failures.update(wrong)
            slowest, done = max(slowest, slow), done + count
            for kind, number in own.items():
                outcomes[kind] = outcomes.get(kind, 0) + number
            print(f"{name}: {done} cases, {len(failures)} failures", flush=True)
            report(text + lines(name, outcomes, failures, time.process_time() - start, slowest, done), asked)
        text += lines(name, outcomes, failures, time.process_time() - start, slowest, done)
        failed += len(failures)
        for sentence, example in failures.items():
            print(sentence, "\n", str(example)[:2000])
            if isinstance(example, tuple):
                traceback.print_exception(example[1])
    return 1 if failed else 0


def lines(name, outcomes, failures, seconds, slowest, done):
    """What docs/fuzz.md says of one level."""
    rows = [f"| {n} | {kind[:140]} |" for kind, n in sorted(outcomes.items(), key=lambda item: -item[1])[:25]]
    head = f"{done} cases in {seconds:.0f} s of CPU, the slowest {slowest:.1f} s; {len(failures)} failures."
    return ["", f"## {name}", "", head, "", "| cases | outcome |", "|---|---|", *rows]


def report(text, asked):
    """Write docs/fuzz.md."""
    head = (ROOT / "docs" / "fuzz.md").read_text(encoding="utf-8").split("<!-- last run -->")[0]
    told = f"<!-- last run -->\n\nLast run, {date.today()}, `tests/fuzz/run.py --cases {asked.cases}`:"
    (ROOT / "docs" / "fuzz.md").write_text("\n".join([head + told, *text]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
