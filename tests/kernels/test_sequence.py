"""Frames of one animation: each is a function of the anchor and itself, and rough pictures change nothing."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from waves import five_sines, floor, pool, quad, sun, water

from dapple.kernels import methods
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Occluder, Settings
from dapple.kernels.sequence import Sequence
from dapple.kernels.unchanged import unchanged


class Counted:
    """`methods.solve`, and how often it was asked."""

    def __init__(self):
        self.tolerances = []

    def __call__(self, scene, texels, settings, kept=None):
        self.tolerances.append(settings.tolerance)
        return methods.solve(scene, texels, settings, kept)


def scene(quads=24):
    raft = floor(side=0.5, z=0.7)
    return pool(quads=quads, occluders=[Occluder("Raft", raft.positions, raft.triangles)])


def texels(of):
    return tuple(rasterise(r, 32) for r in of.receivers)


def lifted(thing):
    return replace(thing, positions=thing.positions + np.array([0, 0, 1e-9]))


CHANGES = {
    "water": lambda s: replace(s, water=lifted(s.water)),
    "normals": lambda s: replace(s, water=replace(s.water, normals=s.water.normals[:, [1, 0, 2]])),
    "receiver": lambda s: replace(s, receivers=(lifted(s.receivers[0]),)),
    "occluder": lambda s: replace(s, occluders=(lifted(s.occluders[0]),)),
    "fewer": lambda s: replace(s, occluders=()),
    "light": lambda s: replace(s, lights=(sun((0.25, 0.1, -1.0), (1.0, 1.0, 0.9)),)),
    "eta": lambda s: replace(s, eta=1.34),
    "sigma_a": lambda s: replace(s, sigma_a=np.array([0.1, 0.0, 0.0])),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_whatever_changes_is_seen(change):
    assert unchanged(scene(8), scene(8))  # equal arrays, not the same ones
    assert not unchanged(scene(8), change(scene(8)))


@pytest.mark.parametrize("settings", [Settings(tolerance=1e-3), Settings(tolerance=0.1, reuse=0.5)])
def test_rough_pictures_come_first_and_leave_the_last_bit_for_bit_alone(settings):
    """Over two frames, so that what the sequence keeps between them is seen too."""
    solve, known = Counted(), texels(scene())
    passes, plain = Sequence(solve, settings), Sequence(methods.solve, settings)
    for number in (1, 2):
        one = replace(scene(), water=water(lambda x, y, by=number: five_sines(x, y, by / 2), 24))
        solve.tolerances.clear()
        rough = list(passes.rough(one, known))
        last, expected = passes.solve(number, one, known), plain.solve(number, one, known)
        assert (last.images[0] == expected.images[0]).all()
        assert len(rough) >= 1
        assert all(a > b for a, b in zip(solve.tolerances, solve.tolerances[1:], strict=False))
        for picture in rough:
            assert picture.images[0].mean() == pytest.approx(expected.images[0].mean(), rel=0.5)


def test_light_is_kept_from_the_frame_before_only():
    settings = Settings(tolerance=0.1, reuse=0.5, surface="mesh")
    calm, rough = scene(8), replace(scene(8), water=water(lambda x, y: five_sines(x, y, 2.0), 8))
    known = texels(calm)
    own = methods.solve(rough, known, settings).images[0]
    for number, mixed in ((2, True), (3, False)):
        sequence = Sequence(methods.solve, settings)
        before = sequence.solve(1, calm, known).images[0]
        image = sequence.solve(number, rough, known).images[0]
        np.testing.assert_allclose(image, (before + own) / 2 if mixed else own, rtol=1e-12)


def test_two_receivers_keep_their_own():
    left, right = (
        quad(name, [[x, -2, 0], [x + 2, -2, 0], [x + 2, 2, 0], [x, 2, 0]]) for name, x in (("Left", -2), ("Right", 0))
    )
    one = pool(quads=8, receivers=[left, right])
    sequence, known = Sequence(methods.solve, Settings(tolerance=0.1, reuse=0.5)), texels(one)
    first = sequence.solve(1, one, known)
    second = sequence.solve(2, one, known)
    for a, b in zip(first.images, second.images, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12)


def noisy(number, steepness=1.0):
    """A frame of waves whose vertices are off the surface by 0.3 mm: a little, so that smoothing is a choice."""
    mesh = water(lambda x, y: five_sines(x, y, steepness), 48)
    off = 3e-4 * np.random.default_rng(number).standard_normal(len(mesh.positions))
    return replace(scene(8), water=replace(mesh, positions=mesh.positions + off[:, None] * [0, 0, 1]))


def test_a_frame_is_a_function_of_the_anchor_and_itself():
    """Frames solved in turn, alone, backwards and by another process's copy of the anchor are the same, bit for bit;
    the third is so much rougher than the anchor that it chooses for itself."""
    settings, frames = Settings(tolerance=1e-3), [noisy(1, 0.1), noisy(2, 0.12), noisy(3, 1.0)]
    known = tuple(rasterise(r, 128) for r in frames[0].receivers)
    anchor = methods.prepare(frames[0], known, settings)
    assert pickle.loads(pickle.dumps(anchor)) == anchor
    in_turn = Sequence(methods.solve, settings, anchor)
    maps = [in_turn.solve(k, frame, known) for k, frame in enumerate(frames)]
    backwards = Sequence(methods.solve, settings, pickle.loads(pickle.dumps(anchor)))
    for k in (2, 1, 0):
        other = backwards.solve(k, frames[k], known)
        assert other.diagnostics.surface == maps[k].diagnostics.surface
        np.testing.assert_array_equal(other.images[0], maps[k].images[0])
    said = [one.diagnostics.surface for one in maps]
    assert said[0].split(",")[1] == said[1].split(",")[1] == f" lambda = {anchor.smoothing.value:g}"
    assert said[2].split(",")[1] != said[0].split(",")[1]


def test_an_anchor_of_the_mesh_as_it_is_chooses_nothing():
    one = noisy(1)
    anchor = methods.prepare(one, texels(one), Settings(surface="mesh"))
    assert anchor.smoothing.value is None
