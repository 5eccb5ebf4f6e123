"""The choice of method, and how its parts share the tolerance."""

from dataclasses import replace

import numpy as np
import pytest
from casters import ball
from waves import floor, pool, sun, water

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, solve
from dapple.kernels.scene import Receiver, Scene, Settings, Sun, Water


def test_auto_takes_the_one_that_finds_all_light():
    scene = pool(quads=8)
    answer = solve(scene, [rasterise(scene.receivers[0], 8)], Settings())
    assert answer.diagnostics.method == "photon_splat"


def test_unknown_method_names_the_known():
    with pytest.raises(ValueError, match="conic_walk") as caught:
        solve(pool(quads=2), [], Settings(method="newton"))
    assert all(name in str(caught.value) for name in METHODS)


@pytest.mark.parametrize("method", METHODS)
def test_far_from_the_origin_is_as_near(method):
    near = pool(quads=24)
    w, f = near.water, near.receivers[0]
    away = np.array([1e5, -2e5, 3e4])
    far_water = Water("W", w.positions + away, w.triangles, w.normals, w.triangles, w.twins)
    far = Scene(far_water, (Receiver("Floor", f.positions + away, f.triangles, f.uvs),), (), near.lights)
    here, there = (solve(scene, [rasterise(scene.receivers[0], 32)], Settings(method=method)) for scene in (near, far))
    assert there.diagnostics.texels == here.diagnostics.texels == {"lit": 32 * 32}
    received = [d.flux_received["Floor"][0] for d in (here.diagnostics, there.diagnostics)]
    assert received[1] == pytest.approx(received[0], rel=1e-4)


def test_arrays_that_do_not_fit_are_named():
    f, w, s = floor(), water(quads=2), sun()
    with pytest.raises(ValueError, match=r"uvs must have shape \(2, 3, 2\)"):
        Receiver("R", f.positions, f.triangles, f.uvs[:1])
    with pytest.raises(ValueError, match=r"positions must have shape \(n, 3\)"):
        Receiver("R", f.positions[:, :2], f.triangles, f.uvs)
    with pytest.raises(ValueError, match=r"triangles must lie in \[0, 3\)"):
        Receiver("R", f.positions[:3], f.triangles, f.uvs)
    with pytest.raises(ValueError, match="twins must have shape"):
        Water("W", w.positions, w.triangles, w.normals, w.normal_triangles, w.twins[:-1])
    with pytest.raises(ValueError, match="direction must be a unit vector"):
        Sun("S", s.direction * 2, s.irradiance)
    with pytest.raises(ValueError, match="one entry per receiver"):
        solve(Scene(w, (f,), (), (s,)), [], Settings())


def under_a_wide_sun(scene, degrees):
    return replace(scene, lights=tuple(replace(light, angle=np.radians(degrees)) for light in scene.lights))


@pytest.mark.parametrize("degrees", [0.0, 2.0])
@pytest.mark.parametrize("tolerance", [3e-2, 3e-3])
def test_surface_disc_and_beams_share_the_tolerance(degrees, tolerance):
    """Together they are off by no more than is asked, nor than about what they say; against water of sixteen times the
    triangles, cells as fine as there are, and beams that err by nearly nothing."""
    coarse, fine = (under_a_wide_sun(pool(quads=quads), degrees) for quads in (80, 320))
    texels = [rasterise(coarse.receivers[0], 96)]
    answer = solve(coarse, texels, Settings(tolerance=tolerance))
    true = solve(fine, texels, Settings(tolerance=1e-5, surface="mesh")).images[0]
    error = ((answer.images[0] - true) ** 2).mean() / (true**2).mean()
    estimate = answer.diagnostics.estimated_error
    assert max(error, estimate) <= tolerance
    assert error / 3 < estimate < 10 * error


def test_what_a_wide_sun_blurs_needs_no_fine_surface():
    scene = pool(quads=64)
    texels = [rasterise(scene.receivers[0], 128)]
    paths = [
        solve(under_a_wide_sun(scene, degrees), texels, Settings("photon_splat", 3e-4)).diagnostics.paths["beams"]
        for degrees in (0.0, 2.0, 8.0)
    ]
    assert paths[0] >= paths[1] >= paths[2] and paths[0] > paths[2]


@pytest.mark.parametrize("method", [m for m in METHODS if m not in ("photon_splat", "caustic_map")])
def test_what_knows_no_casters_gives_no_error_for_them(method):
    scene = replace(pool(quads=8), casters=(ball(0.2, (0, 0, 2.0), fine=6),))
    d = solve(scene, [rasterise(scene.receivers[0], 16)], Settings(method, 0.3, surface="mesh")).diagnostics
    assert d.estimated_error is None and any("glass" in sentence for sentence in d.left_out)


@pytest.mark.parametrize("method", [name for name in METHODS if name != "flat"])
def test_every_estimate_is_over_the_mean_square(method):
    """Inside, errors are over the squared mean of the light, which is less by its variance."""
    scene, settings = pool(quads=48), Settings(method, 0.05, surface="mesh")
    texels = [rasterise(scene.receivers[0], 32)]
    inside = METHODS[method](scene, texels, settings)
    light = inside.images[0].sum(2)
    power = (light**2).mean() / light.mean() ** 2
    assert power > 1.001
    told = solve(scene, texels, settings).diagnostics.estimated_error
    assert told * power == pytest.approx(inside.diagnostics.estimated_error, rel=1e-6)
