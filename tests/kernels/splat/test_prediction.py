"""What beams will leave as error: how far images bend, which are torn, and how many errors a tolerance takes."""

import numpy as np
import pytest

from dapple.kernels.splat.prediction import bend, cut_off, predict

X, Y = np.array([[0.0], [4.0], [0.0]]) + 3, np.array([[0.0], [0.0], [4.0]]) + 3


def test_the_bend_of_a_quadratic_is_a_quarter_of_its_second_difference():
    corners = np.array([[0.0], [1.0], [0.0]])
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    along = np.concatenate([corners, middles])
    assert bend(along**2 + 3 * along - 1) == pytest.approx(1 / 4)
    assert bend(3 * along - 1) == pytest.approx(0, abs=1e-15)


def test_the_error_grows_with_the_square_of_bend_and_flux():
    one = predict(np.array([0.1]), X, Y, np.array([1.0]), (1.0, 0.0), 64)
    assert predict(np.array([0.2]), X, Y, np.array([3.0]), (1.0, 0.0), 64) == pytest.approx(36 * one)
    assert predict(np.zeros(1), X, Y, np.array([1.0]), (1.0, 0.0), 64) == 0
    uneven = predict(np.zeros(1), X, Y, np.array([1.0]), (np.ones(1), np.array([0.5])), 64)
    assert uneven == pytest.approx(0.25 / 9 / 16)  # length times width is twice the area


def test_torn_images_are_no_beams_and_those_beside_the_map_have_no_error():
    assert np.isinf(predict(np.array([5.0]), X, Y, np.array([1.0]), (1.0, 0.0), 64))
    assert predict(np.array([0.5]), X - 20, Y, np.array([1.0]), (1.0, 0.0), 64) == 0


@pytest.mark.parametrize("most", [0.0, 0.05, 1.0, 7.0, 1e3])
def test_the_least_errors_are_taken_up_to_their_sum(most):
    error = np.random.default_rng(3).random(64)
    limit = cut_off(error, most)
    taken = error[error <= limit]
    assert taken.sum() <= most
    if len(taken) < len(error):
        assert taken.sum() + error[error > limit].min() > most


def test_what_weighs_more_may_be_more_wrong():
    """The same sum, but the first to stay are those of the largest error over their weight."""
    error, weight = np.array([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 1.0, 10.0, 10.0])
    assert cut_off(error, 3.5) == 2.0
    most = cut_off(error, 8.0, weight)
    np.testing.assert_array_equal(error <= most * weight, [True, False, True, True])
    assert cut_off(error, 0.5, weight) == -1 and cut_off(error, 10.0, weight) == np.inf
