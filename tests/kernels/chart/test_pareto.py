"""The front, against all pairs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dapple.kernels.chart.pareto import front, over_front

RUNS = st.lists(st.tuples(st.integers(1, 6), st.integers(1, 6)), min_size=1, max_size=12)


@given(RUNS)
def test_front_is_what_no_other_beats(runs):
    seconds, errors = np.array(runs, float).T
    on = front(seconds, errors)
    for k, (time, error) in enumerate(runs):
        beaten = any(t <= time and e <= error and (t, e) != (time, error) for t, e in runs)
        first = runs.index((time, error)) == k
        assert on[k] == (first and not beaten)


def test_no_error_that_is_not_finite_is_on_a_front():
    assert front([1.0, 2.0], [np.inf, np.nan]).tolist() == [False, False]


def test_time_over_the_front():
    seconds, errors = [1.0, 2.0, 4.0], [0.3, 0.1, 0.1]
    assert over_front(3.0, 0.1, seconds, errors) == pytest.approx(1.5)
    assert over_front(3.0, 0.2, seconds, errors) == pytest.approx(1.5)
    assert over_front(3.0, 0.5, seconds, errors) == pytest.approx(3.0)
    assert over_front(0.5, 0.01, seconds, errors) == 0.0


def test_shapes_that_differ():
    with pytest.raises(ValueError, match=r"one shape"):
        front([1.0], [1.0, 2.0])
