"""Runs cases and counts what becomes of them; one that hangs, or ends in neither answer nor sentence, fails."""

import re
import signal
import time
from collections import Counter

from hypothesis import HealthCheck, Phase, given, seed, settings

HANGS = 100  # s of this process's own time


class Hang(BaseException):
    """A case that takes longer than any small scene can."""


def fuzz(cases, run, count, number=0):
    """(outcomes, failures, slowest) of `count` cases of a strategy by `run`, from the seed `number`: sentences with
    how many cases ended in each; failures with an example of each; s of CPU of the slowest case."""
    outcomes, failures, slowest = Counter(), {}, [0.0]

    @seed(number)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(cases())
    def one(case):
        start = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, HANGS)
        try:
            outcomes[_kind(run(case))] += 1
        except Hang:
            failures.setdefault(f"no end after {HANGS} s", case)
        except Exception as error:
            failures.setdefault(f"{type(error).__name__}: {error}", (case, error))
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        slowest[0] = max(slowest[0], time.process_time() - start)

    before = signal.signal(signal.SIGPROF, _stop)
    try:
        one()
    finally:
        signal.signal(signal.SIGPROF, before)
    return outcomes, failures, slowest[0]


def _stop(*_):
    raise Hang


def _kind(sentence):
    """A sentence without its names and numbers."""
    text = re.sub(r"'[^']*'|\"[^\"]*\"|\[[^\]]*\]|\([^)]*\)", "...", sentence)
    return re.sub(r"[-+]?(\d[\d.]*(e[-+]?\d+)?|inf|nan)\b%?", "#", text)
