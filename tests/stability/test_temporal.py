"""In time: what stands still stays, what travels shifts, and slow waves do not flicker."""

import hashlib
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from waves import AMPLITUDE, HEADING, PHASE, WAVELENGTH, pool, water

from dapple.kernels.anchor import Kept
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import prepare, solve
from dapple.kernels.scene import Settings
from dapple.tests.stability.judge import METHODS, NOT_MEANS, SAMPLED, Verdict, run

SIDE = 32
TEXEL = 4.0 / SIDE
_HASH = """
import sys
sys.path.insert(0, sys.argv[1] + "/tests")
import conftest
from dapple.tests.stability.test_temporal import digests
from waves import pool

print(*digests(pool(quads=48)))
"""


def digests(scene):
    """A digest of every method's map of the mesh, and of one of the smooth water."""
    maps = [run(scene, SIDE, *how).images[0] for how in (*((m, "mesh") for m in METHODS), ("beams", "auto"))]
    return [hashlib.sha256(image.tobytes()).hexdigest() for image in maps]


def test_a_static_scene_gives_the_same_bits(row, root):
    """A static scene, baked again in the same process and in fresh ones

    Nothing moves, so no bit may differ: no seed, clock, address or order of threads is in the answer, by the mesh or by
    the smooth water.
    """
    row.tolerance = "0"
    here = [digests(pool(quads=48)) for _ in range(2)]
    fresh = subprocess.run([sys.executable, "-c", _HASH, str(root)], capture_output=True, text=True, check=True).stdout
    row.cells = {m: Verdict("right", "", 0.0) for m in METHODS}
    assert here[0] == here[1] == fresh.split()


def waves_at(time=0.0, shift=0.0):
    """The pool's waves after `time` s, moved by `shift` m along x: height and slopes of (x, y)."""
    k = 2 * np.pi / WAVELENGTH

    def shape(x, y):
        phase = k * ((x[..., None] - shift) * np.cos(HEADING) + y[..., None] * np.sin(HEADING)) + PHASE
        phase = phase - np.sqrt(9.81 * k) * time
        slope = AMPLITUDE * k * np.cos(phase)
        return (AMPLITUDE * np.sin(phase)).sum(-1), (slope * np.cos(HEADING)).sum(-1), (slope * np.sin(HEADING)).sum(-1)

    return shape


def relative(a, b):
    """Relative mean squared error of a against b."""
    return float(((a - b) ** 2).mean() / (b**2).mean())


def mesh_moved(quads, shift):
    """The pool at rest under 7 m of water, the whole mesh moved along x."""
    w = water(waves_at(), quads, 7.0)
    return replace(pool(quads=2), water=replace(w, positions=w.positions + np.array([shift, 0, 0])))


def waves_moved(quads, shift):
    """The same, the mesh staying and the waves moved through it."""
    return replace(pool(quads=2), water=water(waves_at(shift=shift), quads, 7.0))


def mismatch(build, quads, method, surface="mesh"):
    """Relative mean squared difference of two maps, of water and of the same one texel on, laid over each other, but
    for the outermost texels."""
    first, second = (run(build(quads, shift), SIDE, method, surface).images[0][..., 0] for shift in (0.0, TEXEL))
    return relative(second[1:-1, 2:-1], first[1:-1, 1:-2])


@pytest.mark.parametrize(
    ("quads", "surface", "methods"),
    [(112, "mesh", tuple(METHODS)), (97, "mesh", tuple(METHODS)), (97, "auto", ("beams", "points"))],
    ids=["2 quads a texel", "1.7 quads a texel", "1.7 quads a texel, smooth water"],
)
def test_a_mesh_that_travels_by_a_texel(row, quads, surface, methods):
    """Waves that travel by one texel, and their mesh with them

    The same water a texel further on: the map shifts by a texel, to rounding, whatever the mesh's spacing.
    """
    row.tolerance = "1e-18"
    _shifts(row, mesh_moved, quads, surface, methods)


def test_waves_that_travel_by_a_texel_through_a_mesh_that_fits(row):
    """Waves that travel by one texel through a fixed mesh, 2 quads a texel

    Every vertex takes the place and height of the one two before it: the map shifts by a texel, to rounding. Points are
    noise that stays with the mesh.
    """
    row.tolerance = "1e-18"
    _shifts(row, waves_moved, 112, "mesh", METHODS)


def _shifts(row, build, quads, surface, methods):
    """The methods' maps must shift to rounding; sampled ones within their noise, where that does not travel: that of
    points stays with the mesh, that of all roots with the texels."""
    bad = []
    for method in methods:
        settings, found = METHODS[method], mismatch(build, quads, method, surface)
        stays = method == "all roots" or (method in SAMPLED and build is waves_moved)
        allowed = 4 * settings.tolerance if stays else 1e-18
        row.cells[method] = Verdict("right" if found <= allowed else "wrong", f"{found:.1e}", found)
        if not found <= allowed:
            bad.append(f"{method}: {found:.1e}")
    assert not bad, bad


@pytest.mark.parametrize(
    ("surface", "most", "methods"),
    [("mesh", 2e-2, tuple(METHODS)), ("auto", 2e-4, ("beams", "points"))],
    ids=["mesh", "smooth water"],
)
def test_waves_that_travel_by_a_texel_through_a_mesh_that_does_not_fit(row, surface, most, methods):
    """Waves that travel by one texel through a fixed mesh, 1.7 quads a texel

    Each map differs from that of the true waves by its mesh's error e, so both differ from each other by (2 sqrt e)^2
    at most. The smooth water has a fraction of the raw mesh's e.
    """
    quads = 97
    fine = run(waves_moved(4 * quads, 0.0), SIDE, "beams").images[0][..., 0]
    error = relative(run(waves_moved(quads, 0.0), SIDE, "beams", surface).images[0][..., 0], fine)
    row.tolerance = f"4 x {error:.0e}"
    assert error < most
    bad = []
    for method in methods:
        settings, found = METHODS[method], mismatch(waves_moved, quads, method, surface)
        right = found <= 4 * error + (4 * settings.tolerance if method in SAMPLED else 0)
        outcome = "right" if right else "reported" if settings.first_root else "wrong"
        row.cells[method] = Verdict(outcome, f"left out: {NOT_MEANS}", found)
        if outcome == "wrong":
            bad.append(f"{method}: {found:.1e}")
    assert not bad, bad


def flicker(frames):
    """Mean absolute second difference in time of maps (n,H,W)."""
    return np.abs(np.diff(frames, 2, axis=0)).mean()


def frames(quads, settings, resolution=128, step=1 / 240):
    """Maps (3,H,W) of the pool's waves `step` s apart, and the estimated error of the last."""
    maps, kept, texels = [], None, None
    for k in range(3):
        scene = replace(pool(quads=2), water=water(waves_at(k * step), quads, 4.8))
        texels = texels or [rasterise(scene.receivers[0], resolution)]
        kept = kept or Kept(prepare(scene, texels, settings))
        answer = solve(scene, texels, settings, kept)
        maps.append(answer.images[0][..., 0])
    return np.array(maps), answer.diagnostics.estimated_error


def test_slow_waves_do_not_flicker(row):
    """Slow waves, 240 frames a second, 33 thousand triangles against ten times as many

    The mean absolute second difference in time is that of the light itself, within 1 % at a tolerance of 1e-5: the
    smooth water has the motion of the true one. Photons that jump about have more, and their estimated error says so.
    """
    row.tolerance = "1 %"
    true = flicker(frames(400, Settings(tolerance=1e-6, surface="mesh"))[0])
    found = {}
    for method in ("beams", "points"):
        tolerance = METHODS[method].tolerance * (0.1 if method == "beams" else 1)
        maps, estimate = frames(128, replace(METHODS[method], surface="auto", tolerance=tolerance))
        found[method] = flicker(maps) / true - 1
        if abs(found[method]) <= 0.01:
            row.cells[method] = Verdict("right", f"{found[method]:+.1%}", found[method])
        else:
            row.cells[method] = Verdict("reported", f"estimated error: {estimate:.0e}, as noise", found[method])
    assert abs(found["beams"]) <= 0.01, found
    assert found["points"] > 0.01, "or points are right, and the table should say so"
