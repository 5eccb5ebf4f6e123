"""Numbers by chance that depend on what they are for alone."""

import numpy as np

from dapple.kernels.chance import uniform


def test_they_are_even_and_apart():
    i, j = (v.ravel() for v in np.meshgrid(np.arange(200), np.arange(200)))
    drawn = np.concatenate([uniform(0, i, j), uniform(1, i, j), uniform(0, i * 0.1, j * 0.1)])
    assert (drawn >= 0).all() and (drawn < 1).all()
    noise = 4 / np.sqrt(drawn.shape[1])
    np.testing.assert_allclose(drawn.mean(1), 0.5, atol=noise * np.sqrt(1 / 12))
    np.testing.assert_allclose(np.cov(drawn), np.eye(6) / 12, atol=noise / 6)


def test_they_do_not_depend_on_what_else_is_asked():
    i, j = np.arange(-50, 50), np.arange(100)[::-1]
    np.testing.assert_array_equal(uniform(7, i, j)[:, 30:40], uniform(7, i[30:40], j[30:40]))
