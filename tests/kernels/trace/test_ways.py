"""Ways of light in an order of their own, and points by number."""

from dataclasses import fields

import numpy as np

from dapple.kernels.trace.places import keys
from dapple.kernels.trace.ways import Ways


def test_ways_are_ordered_by_photons_and_codes():
    rng = np.random.default_rng(1)
    photon, code = rng.permutation(np.stack(np.divmod(np.arange(500_000), 5)), axis=1)
    columns = {f.name: np.arange(len(photon)) for f in fields(Ways)} | {"photon": photon, "code": code}
    ordered = Ways(**columns | {"colour": np.stack([photon, code])}).ordered()
    np.testing.assert_array_equal(ordered.photon * 5 + ordered.code, np.arange(500_000))
    np.testing.assert_array_equal(ordered.colour, [ordered.photon, ordered.code])
    np.testing.assert_array_equal(ordered.photon, photon[ordered.x])


def test_points_have_numbers_of_their_own_and_neighbours_lie_together():
    rng = np.random.default_rng(1)
    m = rng.uniform(-1, 1, (3, 20_000))
    own = keys(m, 1 / 64)
    assert len(np.unique(own)) == len(own)
    np.testing.assert_array_equal(keys(m[:, 100:200], 1 / 64), own[100:200])
    ordered = m[:, np.argsort(own)]
    assert np.linalg.norm(np.diff(ordered), axis=0).mean() < 0.15 * np.linalg.norm(np.diff(m), axis=0).mean()
