"""Runs every method on a construction, keeps the verdicts, and writes them as a table where it is asked to.

`./dapple test tests/stability --stability-table docs/stability.md`
"""

import inspect

import pytest

from dapple.tests.stability.judge import COMPLETE, METHODS, NOT_MEANS, ONE_PATH, RUNGS, SAMPLED, judge, judge_rung, run
from dapple.tests.stability.table import Row, page

ROWS = pytest.StashKey[list]()


def pytest_addoption(parser):
    parser.addoption("--stability-table", default=None, help="write the table of constructions and verdicts here")


@pytest.fixture
def row(request):
    """The Row of the running test, kept for the table: its words come from the test's docstring."""
    first, _, why = inspect.getdoc(request.function).partition("\n\n")
    case = getattr(request.node, "callspec", None)
    row = Row(" ".join(first.split()), case.id if case else "", " ".join(why.split()), request.node.nodeid)
    request.config.stash.setdefault(ROWS, []).append(row)
    return row


@pytest.fixture
def every_method(row):
    """Judge all methods on a scene; the test fails where one is wrong, or worse than it is known to be."""

    def check(scene, expected, resolution, tolerance=1e-3, worst=0.05, right=COMPLETE, sentences=()):
        """right: methods that must be right here; the others may be reported, by a status, by what they always leave
        out, or by one of `sentences`. Sampled methods are as exact as they are asked to be: four times that tolerance,
        and half of a texel's light, are theirs."""
        row.tolerance = f"{tolerance:g}, {worst:g}"
        bad = []
        for method, settings in METHODS.items():
            answer = run(scene, resolution, method)
            found = answer.images, answer.status, answer.diagnostics.left_out
            sampled = (tolerance + 4 * settings.tolerance, max(worst, 0.5))
            allowed = sampled if method in SAMPLED else (tolerance, worst)
            verdict = judge(*found, expected, *allowed, (*sentences, ONE_PATH, NOT_MEANS))
            row.cells[method] = verdict
            if verdict.outcome == "wrong" or (verdict.outcome == "reported" and method in right):
                bad.append(f"{method}: {verdict.outcome}, {verdict.why}")
        for rung in RUNGS:
            verdict = row.cells[rung] = judge_rung(run(scene, resolution, rung), expected)
            if verdict.outcome == "wrong":
                bad.append(f"{rung}: {verdict.why}")
        assert not bad, "; ".join(bad)

    return check


def pytest_sessionfinish(session):
    path = session.config.getoption("--stability-table", default=None)
    rows = session.config.stash.get(ROWS, [])
    if path and rows:
        with open(path, "w", encoding="utf-8") as file:
            file.write(page(rows))
