"""A few hundred cases of what `run.py` does by the ten thousand."""

import pytest

from dapple.tests.fuzz import kernel_cases
from dapple.tests.fuzz.fuzz import fuzz


def assert_sound(cases, run, count):
    outcomes, failures, _ = fuzz(cases, run, count)
    assert not failures, "\n".join(failures)
    assert outcomes["answered"] > 0.3 * count
    assert len(outcomes) > 3  # sentences as well


def test_kernels_answer_or_refuse_in_a_sentence():
    assert_sound(kernel_cases.cases, kernel_cases.run, 150)


def test_files_are_baked_or_refused_in_a_sentence(request):
    pytest.importorskip("bpy")
    request.getfixturevalue("empty_scene")
    from dapple.tests.fuzz import operator_cases

    assert_sound(operator_cases.cases, operator_cases.run, 150)
