"""Equal inputs have one name, others have another."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from waves import pool

from dapple.operators.read.digest import checksum, code, digest


@dataclass(frozen=True)
class Thing:
    name: str
    values: np.ndarray


def test_equal_things_have_one_name_wherever_their_arrays_lie():
    one, other = pool(quads=4), pool(quads=4)
    assert one.water.positions is not other.water.positions
    assert digest(one) == digest(other)
    every = np.arange(12.0).reshape(3, 4)
    assert digest(every.T) == digest(np.ascontiguousarray(every.T)) != digest(every)


UNLIKE = [
    (np.zeros(3), np.zeros(4)),
    (np.zeros((2, 3)), np.zeros((3, 2))),
    (np.zeros(3), np.zeros(3, np.float32)),
    (np.zeros(2), np.array([0.0, 5e-324])),
    (("a", "bc"), ("ab", "c")),
    ((1, (2, 3)), ((1, 2), 3)),
    (1, 1.0),
    (1, True),
    (None, "None"),
    (b"a", "a"),
    ({"a": 1}, {"a": 2}),
    (Thing("a", np.zeros(2)), Thing("b", np.zeros(2))),
]


@pytest.mark.parametrize(("one", "other"), UNLIKE)
def test_unlike_things_have_other_names(one, other):
    assert digest(one) != digest(other)
    assert digest(one) == digest(one)


def test_one_bit_of_a_scene_is_another_name():
    scene = pool(quads=4)
    positions = scene.water.positions.copy()
    positions[7, 2] = np.nextafter(positions[7, 2], 9)
    assert digest(replace(scene, water=replace(scene.water, positions=positions))) != digest(scene)


def test_what_may_be_equal_and_look_different_has_none():
    for thing in (object(), {1, 2}, np.array([object()])):
        with pytest.raises(TypeError, match="digest knows no"):
            digest(thing)


def test_names_are_short_and_those_of_files_are_of_their_bytes():
    assert len(digest(1)) == len(checksum(b"")) == len(code()) == 32
    assert checksum(b"a") != checksum(b"b")
