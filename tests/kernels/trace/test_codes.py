"""Codes that are followed together, along the ways that they share."""

import numpy as np
import pytest
from caster_rays import scene
from casters import ball

from dapple.kernels.trace.codes import MOST, Codes
from dapple.kernels.trace.follow import Follower, Rays
from dapple.kernels.trace.surfaces import Surfaces

WORDS = [0b10, 0b111, 0b1101, 0b11001]


def test_a_prefix_leads_to_the_codes_that_begin_with_it():
    codes = Codes([0b1, 0b111, 0b1101])
    inside = codes.step[1][0]  # 0b11
    assert codes.below[0] == 0b111 and codes.own[0] == 0b001
    assert codes.below[inside] == 0b110 and codes.own[inside] == 0
    assert codes.below[codes.step[0][0]] == 0, "no code begins by being turned back"
    want = np.array([0b001, 0b010, 0b110])
    np.testing.assert_array_equal(codes.leads(1, np.zeros(3, int), want), [False, True, True])
    np.testing.assert_array_equal(codes.leads(0, np.full(3, inside), want), [False, False, True])
    with pytest.raises(ValueError, match="words"):
        Codes(range(1, MOST + 2))


def test_codes_together_are_what_each_is_alone():
    """Rays through a ball: the same ends, shares and directions, by fewer rays."""
    surfaces = Surfaces(scene(ball(fine=48)), np.ones(3))
    x = np.linspace(-0.9, 0.9, 40)
    origin, direction = np.stack([x, 0 * x, 0 * x + 3]), np.tile([[0.0], [0], [-1]], len(x))

    def found(words):
        follower = Follower(surfaces, 6)
        codes = Codes(words)
        parts = [
            (codes.number[rays.code[k]], rays.photon[k], end[k], rays.share[k], *rays.direction[:, k])
            for rays, end in follower.ends(Rays.of(origin, direction, 1), codes)
            for k in range(len(end))
        ]
        return parts, follower.cast

    together, cast = found(WORDS)
    alone, casts = zip(*(found([word]) for word in WORDS), strict=True)
    assert sorted(together) == sorted((k, *part[1:]) for k, parts in enumerate(alone) for part in parts)
    assert len(together) >= 3 * len(x) and cast < 0.75 * sum(casts)


def test_a_photon_is_followed_as_far_as_it_asks():
    surfaces, codes = Surfaces(scene(ball(fine=48)), np.ones(3)), Codes(WORDS)
    origin, direction = np.array([[0.1, 0.2], [0, 0], [3, 3]]), np.array([[0.0, 0], [0, 0], [-1, -1]])
    ended = [
        (int(rays.photon[k]), WORDS[codes.number[rays.code[k]]])
        for rays, _ in Follower(surfaces, 6).ends(Rays.of(origin, direction, 1), codes, np.array([0b0010, 0b0101]))
        for k in range(len(rays.photon))
    ]
    assert sorted(ended) == [(0, 0b111), (1, 0b10), (1, 0b1101)]
