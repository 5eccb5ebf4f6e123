"""Tables of what meetings change, against what they are worked out from, one by one."""

import numpy as np
from caster_rays import scene
from casters import SILVER, ball, slab
from waves import flat, water

from dapple.kernels.casters import Glass
from dapple.kernels.trace.crossings import CHOICE, MIRROR, STRAIGHT
from dapple.kernels.trace.surfaces import Surfaces


def _surfaces():
    parts = ball(fine=8), slab((-2, -2, -2), (2, 2, 2), Glass(1.33)), ball(fine=8, material=SILVER)
    return Surfaces(scene(*parts, over=water(flat, quads=2, side=40, level=5.0)), np.ones(3))


def test_tables_say_what_media_say_of_each_ray():
    """Rays go in and out of bodies by chance, some where they cannot: the same media as by their masks."""
    surfaces, rng = _surfaces(), np.random.default_rng(0)
    crossings, media = surfaces.crossings, surfaces.media
    unit = crossings._unit
    state, kinds = np.zeros(500, int), set()
    for _ in range(12):
        material, enters = rng.integers(0, len(unit), 500), rng.random(500) < 0.6
        key = crossings.key(state, 2 * material, enters)
        before, behind, wrong = media.crossed(crossings.masks[state], unit[material], enters)
        np.testing.assert_array_equal(crossings.masks[crossings.turned[key]], before)
        np.testing.assert_array_equal(crossings.masks[crossings.passed[key]], behind)
        np.testing.assert_array_equal(crossings.wrong[key], wrong)
        np.testing.assert_array_equal(crossings.before[key], media.filling(before))
        np.testing.assert_array_equal(crossings.medium[crossings.passed[key]], media.filling(behind))
        same = media.filling(before) == media.filling(behind)
        kind = np.where(unit[material] == 0, MIRROR, np.where(same, STRAIGHT, CHOICE))
        np.testing.assert_array_equal(crossings.kind[key], kind)
        ratio = media.eta[media.filling(before)] / media.eta[media.filling(behind)]
        np.testing.assert_array_equal(crossings.ratio[key], ratio)
        kinds |= set(kind)
        state = np.where(rng.random(500) < 0.8, crossings.passed[key], crossings.turned[key])
    assert kinds == {CHOICE, STRAIGHT, MIRROR} and len(crossings.masks) > 5


def test_a_state_stands_for_one_mask():
    crossings = _surfaces().crossings
    assert crossings.state(0) == 0 and crossings.medium[0] == 0, "air"
    assert crossings.state(1) == crossings.state(1) == 1
