"""The reconstructed water: nearer to the true one than its mesh, the same in plan, and untouched where it must be."""

from dataclasses import replace

import numpy as np
import pytest
from bench.water_meshes import make
from overhangs import Breaking, Trochoid, angles, meshed, parameters, straight
from waves import five_sines, flat, floor, grid, jittered_grid, mesh_water, pool, shaded_smooth, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Scene, Settings, Water
from dapple.kernels.surface.reconstruct import Need, Reconstruction

FINE = Need(reach=60.0, tolerance=1e-3)


def swell(x, y):
    """The pool's waves, twice as long: a grid of 48 quads has six vertices on the shortest."""
    height, slope_x, slope_y = five_sines(x / 2, y / 2)
    return height, slope_x / 2, slope_y / 2


def jittered(quads=48, side=4.8, shape=swell, seed=0):
    """Waves over a grid whose inner vertices are moved by up to a third of a cell."""
    x, y, triangles = jittered_grid(quads, side, seed)
    return shaded_smooth(np.stack([x, y, shape(x, y)[0]], 1), triangles)


def slope_error(w, shape=swell):
    """Root mean square error of the normals' slopes against the true waves."""
    _, a, b = shape(w.positions[:, 0], w.positions[:, 1])
    n = w.normals
    return np.sqrt(((n[:, 0] / n[:, 2] + a) ** 2 + (n[:, 1] / n[:, 2] + b) ** 2).mean())


def plan_areas(w):
    v = w.positions[w.triangles][:, :, :2]
    a, b = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    return (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def rim(w):
    """Points (n,2) of the rim in plan."""
    half = np.flatnonzero(w.twins < 0)
    return w.positions[w.triangles.ravel()[half], :2]


@pytest.mark.parametrize("irregular", [False, True])
def test_slopes_are_the_waves_not_the_meshs(irregular):
    regular = water(swell, 48, level=0.0)
    mesh = jittered() if irregular else shaded_smooth(regular.positions, regular.triangles)
    smooth, sentence = Reconstruction().apply(mesh, FINE)
    assert "B-spline" in sentence and len(smooth.triangles) > 4 * len(mesh.triangles)
    assert slope_error(smooth) < slope_error(mesh) / 8
    height, _, _ = swell(smooth.positions[:, 0], smooth.positions[:, 1])
    assert np.abs(smooth.positions[:, 2] - height).max() < 1e-3
    np.testing.assert_allclose(np.linalg.norm(smooth.normals, axis=1), 1, rtol=1e-9)
    assert smooth.normal_triangles is smooth.triangles
    np.testing.assert_array_equal(smooth.twins, build_twins(smooth.triangles))


def test_the_image_nears_that_of_the_true_waves():
    """Against beams from a mesh sixteen times finer with exact normals."""
    own = [rasterise(floor(), 128)]
    true = solve(pool(quads=512), own, Settings(surface="mesh")).images[0][..., 0]
    exact = pool(quads=64)
    scene = replace(exact, water=shaded_smooth(exact.water.positions, exact.water.triangles))
    errors = {}
    for surface in ("mesh", "auto"):
        answer = solve(scene, own, Settings(surface=surface))
        errors[surface] = ((answer.images[0][..., 0] - true) ** 2).mean() / true.mean() ** 2
        received = answer.diagnostics.flux_received["Floor"][0]
        assert received == pytest.approx(true.mean() * 16, rel=1e-3)
    assert errors["auto"] < errors["mesh"] / 20


def test_in_plan_nothing_moves():
    mesh = jittered(24)
    hole = ~(np.abs(mesh.positions[mesh.triangles][:, :, :2]).max((1, 2)) < 0.5)
    mesh = shaded_smooth(mesh.positions, mesh.triangles[hole])
    smooth, sentence = Reconstruction().apply(mesh, FINE)
    assert f"{len(mesh.triangles)} of {len(mesh.triangles)}" in sentence
    parts = len(smooth.triangles) // len(mesh.triangles)
    np.testing.assert_allclose(plan_areas(smooth), np.repeat(plan_areas(mesh) / parts, parts), rtol=1e-9)
    assert len(rim(smooth)) == len(rim(mesh)) * np.sqrt(parts)


def test_flat_water_stays_flat():
    for tilt in (0.0, 1e-9, 0.1):
        still = shaded_smooth(*tilted(tilt))
        smooth, sentence = Reconstruction().apply(still, FINE)
        assert smooth is still and "fine enough" in sentence
        smooth, _ = Reconstruction().apply(still, Need(60.0, 1e-300))
        off = smooth.positions[:, 2] - tilt * smooth.positions[:, 0]
        assert np.abs(off).max() < 1e-14 and len(smooth.triangles) >= len(still.triangles)


def tilted(tilt):
    x, y, triangles = grid(16, 4.0)
    return np.stack([x, y, tilt * x], 1), triangles


def test_flat_and_custom_normals_are_the_artists():
    mesh = jittered(16)
    corners = np.arange(mesh.triangles.size).reshape(-1, 3)
    facets = replace(mesh, normals=mesh.normals[mesh.triangles.ravel()], normal_triangles=corners)
    kept, sentence = Reconstruction().apply(facets, FINE)
    assert kept is facets and "set by hand" in sentence


def test_a_setting_keeps_the_mesh():
    scene = pool(quads=64)
    own = [rasterise(floor(), 32)]
    kept = solve(scene, own, Settings(surface="mesh")).diagnostics
    taken = solve(scene, own, Settings(tolerance=1e-4)).diagnostics
    assert "asked for" in kept.surface and "B-spline" in taken.surface and "surface" in taken.seconds
    assert taken.paths["beams"] > kept.paths["beams"]
    with pytest.raises(ValueError, match="surface must be one of auto, mesh"):
        solve(scene, own, Settings(surface="loop"))


def test_a_mesh_fine_enough_is_taken_as_it_is():
    mesh = jittered(48)
    kept, sentence = Reconstruction().apply(mesh, Need(reach=0.01, tolerance=0.1))
    assert kept is mesh and "fine enough" in sentence


def test_a_breaking_wave_is_smooth_on_all_its_sides():
    wave = Breaking()
    mesh = meshed(wave, 96)
    overhang = plan_areas(mesh) < 0
    assert overhang.sum() > 50, "the wave must break, or the test shows nothing"
    smooth, sentence = Reconstruction().apply(mesh, FINE)
    np.testing.assert_array_equal(smooth.twins, build_twins(smooth.triangles))
    flat_parts = straight(mesh, round(np.sqrt(len(smooth.triangles) / len(mesh.triangles))))
    raw, found = (angles(w, wave.normals(w.positions, None)) for w in (flat_parts, smooth))
    assert found.max() < raw.max() / 2
    steep = np.repeat(overhang, len(smooth.triangles) // len(mesh.triangles))
    bent = (smooth.positions != flat_parts.positions).any(1)
    for faces in (smooth.triangles[steep], smooth.triangles[~steep]):
        here = faces[bent[faces].all(1)].ravel()
        assert len(here) > 1000 and np.sqrt((found[here] ** 2).mean()) < np.sqrt((raw[here] ** 2).mean()) / 3
    assert "cubics" in sentence


def test_trochoids_past_their_cusps_are_an_order_better_at_their_folds():
    wave = Trochoid()
    mesh = meshed(wave, 128, 3.2)
    smooth, _ = Reconstruction().apply(mesh, FINE)
    k = round(np.sqrt(len(smooth.triangles) / len(mesh.triangles)))
    flat_parts, s = straight(mesh, k), parameters(128, 3.2, k)
    exact = wave.normals(smooth.positions, s)
    raw, found = angles(flat_parts, wave.normals(flat_parts.positions, s)), angles(smooth, exact)
    folds = exact[:, 2] < 0.5
    inside = np.abs(smooth.positions[:, 1]) < 1.5
    assert (exact[:, 2] < 0).sum() > 1000
    assert np.sqrt((found**2)[folds & inside].mean()) < np.sqrt((raw**2)[folds & inside].mean()) / 10


def test_droplets_and_fins_stay_as_they_are():
    mesh = jittered()
    count = len(mesh.positions)
    drop = np.array([[0, 0, 1.0], [0.05, 0, 1.0], [0, 0.05, 1.02]])
    tip = mesh.positions[1200] + [0.0, 0.0, 0.3]
    fin = [*mesh.triangles[2000, :2], count + 3]
    positions = np.concatenate([mesh.positions, drop, [tip]])
    triangles = np.concatenate([mesh.triangles, [fin, [count, count + 1, count + 2]]])
    mesh = shaded_smooth(positions, triangles)
    smooth, _ = Reconstruction().apply(mesh, FINE)
    np.testing.assert_array_equal(smooth.positions[fin], mesh.positions[fin])
    np.testing.assert_array_equal(smooth.positions[count:][:3], drop)
    np.testing.assert_array_equal(smooth.triangles[-1], mesh.triangles[-1])
    np.testing.assert_array_equal(smooth.twins, build_twins(smooth.triangles))
    assert len(np.unique(np.round(smooth.positions, 12), axis=0)) == len(smooth.positions)


def with_needles(mesh, shape=swell, every=50):
    """The mesh with a vertex of the waves just beside the middle of the diagonals of some of its quads."""
    triangles, positions, count = mesh.triangles.copy(), list(mesh.positions), len(mesh.positions)
    more = []
    for t in range(0, len(triangles) - 1, 2 * every):
        (a, b, c), d = triangles[t], triangles[t + 1, 2]  # a b c and a c d
        x, y = (positions[a] + positions[c])[:2] / 2 + 1e-6
        positions.append([x, y, shape(x, y)[0]])
        middle = count + t // (2 * every)
        triangles[t], triangles[t + 1] = (a, b, middle), (middle, b, c)
        more += [(a, c, d), (a, middle, c)]
    return shaded_smooth(np.array(positions), np.concatenate([triangles, more]))


def test_needles_hide_no_part_of_the_water():
    """Three corners almost in a row in plan, on a bent surface: the facet is steep, the water is not."""
    mesh = with_needles(jittered())
    v = mesh.positions[mesh.triangles]
    facet = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    assert (np.abs(facet[:, 2]) < 0.25 * np.linalg.norm(facet, axis=1)).sum() > 10
    smooth, sentence = Reconstruction().apply(mesh, FINE)
    assert f"for {len(mesh.triangles)} of {len(mesh.triangles)} triangles" in sentence
    assert slope_error(smooth) < slope_error(jittered()) / 8


@pytest.mark.parametrize("kind", ["iso-surface", "interpolated iso-surface"])
def test_iso_surfaces_get_nearer_to_the_water_whether_their_vertices_lie_on_it_or_not(kind):
    """Where they do not, their error follows their cells, and must not be taken for waves."""
    mesh = make(kind, five_sines, 128, 4.8, 0.0)
    smooth, _ = Reconstruction().apply(mesh, FINE)
    assert slope_error(smooth, five_sines) < slope_error(mesh, five_sines) * (0.2 if kind == "iso-surface" else 0.5)


def test_a_step_in_the_water_is_not_smoothed_away():
    """Two levels joined by steep faces, and a crease: vertices stay within a hundredth of their distance."""
    x, y, triangles = grid(40, 4.0)
    z = np.where(x > 0.01, 0.3, 0.0) + 0.2 * np.abs(y)
    mesh = shaded_smooth(np.stack([x, y, z], 1), triangles)
    smooth, _ = Reconstruction().apply(mesh, FINE)
    assert np.abs(smooth.positions[: len(x), 2] - z).max() < 0.02 * 0.1
    assert smooth.positions[:, 2].max() < 0.71 and smooth.positions[:, 2].min() > -0.01


def test_layers_over_each_other_have_surfaces_of_their_own():
    lower, upper = jittered(), jittered(seed=1)
    positions = np.concatenate([lower.positions, upper.positions + np.array([0.3, 0.1, 0.5])])
    triangles = np.concatenate([lower.triangles, upper.triangles + len(lower.positions)])
    smooth, sentence = Reconstruction().apply(shaded_smooth(positions, triangles), FINE)
    assert f"{len(triangles)} of {len(triangles)}" in sentence
    assert np.abs(smooth.positions[: len(positions), 2] - positions[:, 2]).max() < 3e-4


def test_turned_meshes_keep_their_side():
    mesh = jittered(24)
    turned = replace(mesh, normals=-mesh.normals, triangles=mesh.triangles[:, ::-1])
    turned = mesh_water(turned.positions, np.ascontiguousarray(turned.triangles), turned.normals)
    one, other = (Reconstruction().apply(w, FINE)[0] for w in (mesh, turned))
    assert (one.normals[:, 2] > 0).all() and (other.normals[:, 2] < 0).all()
    assert (plan_areas(one) > 0).all() and (plan_areas(other) < 0).all()


def test_frames_share_what_their_triangles_share_and_no_more():
    """A sequence in which the topology changes gives what each frame, equally free of noise, gives alone."""
    frames = [jittered(48), jittered(48, seed=1), jittered(40), jittered(48)]
    shared = Reconstruction()
    for frame in frames:
        together, alone = shared.apply(frame, FINE)[0], Reconstruction().apply(frame, FINE)[0]
        np.testing.assert_array_equal(together.positions, alone.positions)
        np.testing.assert_array_equal(together.triangles, alone.triangles)
        np.testing.assert_array_equal(together.twins, alone.twins)


def test_water_of_few_triangles():
    for quads in (1, 2):
        mesh = shaded_smooth(*grid_water(quads))
        smooth, _ = Reconstruction().apply(mesh, FINE)
        assert np.isfinite(smooth.positions).all() and np.isfinite(smooth.normals).all()
    empty = np.zeros((0, 3), int)
    dry = Water("Dry", np.zeros((0, 3)), empty, np.zeros((0, 3)), empty, np.zeros(0, int))
    assert Reconstruction().apply(dry, FINE)[0] is dry


def grid_water(quads):
    x, y, triangles = grid(quads, 2.0)
    return np.stack([x, y, five_sines(x, y)[0]], 1), triangles


def test_need_grows_with_depth_and_shrinks_with_texels():
    def reach(z, resolution):
        own = [rasterise(floor(z=z), resolution)]
        return Need.of(Scene(water(flat, 4), (floor(z=z),), (), ()), own, 0.01).reach

    assert reach(0.0, 64) == pytest.approx((1 - 1 / 1.333) * 1.5 / (4 / 64))
    assert reach(-1.5, 128) == pytest.approx(4 * reach(0.0, 64))
