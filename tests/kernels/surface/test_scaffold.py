"""What splines need again and again is kept, and made anew where anything of it differs."""

import numpy as np
from waves import five_sines, grid, water

from dapple.kernels.surface import scaffold
from dapple.kernels.surface.bspline import Lattice
from dapple.kernels.surface.reconstruct import Need, Reconstruction
from dapple.kernels.surface.scaffold import Scaffold
from dapple.kernels.surface.smoothing import Smoothing


def test_components_follow_the_triangles():
    _, _, triangles = grid(4, 1.0)
    known, two = Scaffold(), np.concatenate([triangles, triangles + 25])
    assert (known.body(triangles, 25) == 0).all()
    assert known.body(triangles.copy(), 25) is known.body(triangles, 25)
    assert set(known.body(two, 50)) == {0, 25}


def test_samples_follow_points_and_lattice(monkeypatch):
    made = []
    monkeypatch.setattr(scaffold, "Samples", lambda *a: made.append(a) or object())
    x, y = np.random.default_rng(0).random((2, 50))
    coarse, fine = (Lattice(np.zeros(2), np.full(2, 1 / n), (n, n)) for n in (4, 8))
    known = Scaffold()
    one = known.samples(coarse, x, y)
    assert known.samples(fine, x, y) is not one and known.samples(coarse, x.copy(), y) is one
    x[0] += 1e-12  # in place
    assert known.samples(coarse, x, y) is not one and len(made) == 3


def test_a_frame_is_the_same_after_any_other():
    frames = [water(lambda x, y, s=s: five_sines(x + s, y), quads=24) for s in (0.0, 0.3)]
    frames.append(water(quads=20))
    need = Need(30.0, 1e-3)
    kept = Reconstruction(Smoothing(0.002, 10.0))
    for one in (*frames, *frames):
        found, alone = (r.apply(one, need)[0] for r in (kept, Reconstruction(Smoothing(0.002, 10.0))))
        assert len(found.triangles) > len(one.triangles)
        np.testing.assert_array_equal(found.positions, alone.positions)
        np.testing.assert_array_equal(found.normals, alone.normals)
