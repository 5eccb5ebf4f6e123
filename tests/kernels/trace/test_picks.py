"""Parts of columns that are arrays, or one number for all."""

import numpy as np

from dapple.kernels.trace.picks import ALL, chosen, indices, joined, pick, some, whole, within


def test_all_is_not_copied_and_one_number_stays_one():
    column, one = np.arange(6.0).reshape(2, 3), np.array(7)
    assert pick(column, ALL) is column and pick(one, np.array([0, 2])) is one
    np.testing.assert_array_equal(pick(column, np.array([0, 2])), [[0, 2], [3, 5]])
    assert chosen(np.ones(3, bool)) is ALL and not some(chosen(np.zeros(3, bool)))


def test_columns_are_joined_as_if_each_ray_had_its_own():
    one, same, other, column = np.array(7), np.int64(7), np.array(8), np.array([1, 2])
    assert joined(one, same, (2, 3)).ndim == 0
    np.testing.assert_array_equal(joined(one, other, (2, 3)), [7, 7, 8, 8, 8])
    np.testing.assert_array_equal(joined(column, one, (2, 1)), [1, 2, 7])
    np.testing.assert_array_equal(whole(one, 2), [7, 7])
    assert whole(one, 2).dtype == one.dtype and whole(column, 2) is column


def test_what_lies_in_a_row_is_a_slice_and_seen_without_a_copy():
    column, flags = np.arange(10.0).reshape(2, 5), np.array([0, 1, 1, 1, 0], bool)
    part = chosen(flags)
    assert part == slice(1, 4) and some(part) and np.shares_memory(pick(column, part), column)
    assert isinstance(chosen(np.array([1, 0, 1], bool)), np.ndarray)
    np.testing.assert_array_equal(indices(part, 5), [1, 2, 3])


def test_a_part_of_a_part_is_the_part_of_both():
    rng, column = np.random.default_rng(0), np.arange(12)
    for _ in range(200):
        flags = rng.random(12) < rng.choice([0.1, 0.9, 1.0])
        outer = chosen(flags)
        more = rng.random(np.count_nonzero(flags)) < rng.choice([0.5, 1.0])
        np.testing.assert_array_equal(pick(column, within(outer, chosen(more), 12)), column[flags][more])
