"""Tangents from relations along edges: on closed forms, on spheres of any mesh, and not on noise or creases."""

import numpy as np
import pytest
from waves import grid, shaded_smooth

from dapple.kernels.surface.compact import compact


def leaning(x, y, amplitude, lean):
    """A wave's crest sheared sideways, and its exact normals."""
    z, slope = amplitude * np.exp(-((x / 0.4) ** 2)), -2 * x / 0.4**2 * amplitude * np.exp(-((x / 0.4) ** 2))
    normals = np.stack([-slope, 0 * x, 1 + lean * slope])
    return np.stack([x + lean * z, y, z]), normals / np.linalg.norm(normals, axis=0)


def shaded(positions, triangles):
    """Normals (3,V) as Blender makes them."""
    return shaded_smooth(positions.T, triangles).normals.T


def wave(quads, noise=0.0, jitter=0.0, lean=1.6):
    x, y, triangles = grid(quads, 3.0)
    inner = np.maximum(np.abs(x), np.abs(y)) < 1.49
    dx, dy = np.random.default_rng(1).uniform(-jitter, jitter, (2, len(x))) * inner * 3.0 / quads
    positions, exact = leaning(x + dx, y + dy, 0.4, lean)
    positions += noise * np.random.default_rng(0).standard_normal(len(x)) * exact
    return positions, shaded(positions, triangles), triangles, exact


def found(positions, normals, triangles):
    return compact(positions, normals, triangles, np.zeros(len(normals[0]), bool))


def off(normals, exact):
    """Root mean square angle, squared by components."""
    return np.sqrt(((normals - exact) ** 2).sum(0).mean())


@pytest.mark.parametrize("jitter", [0.0, 0.2])
def test_an_overhanging_wave_has_normals_an_order_better_at_its_folds(jitter):
    positions, normals, triangles, exact = wave(96, jitter=jitter)
    assert (exact[2] < 0).sum() > 200, "the wave must overhang, or this shows nothing"
    tangents = found(positions, normals, triangles)
    assert tangents.sound.all()
    for least, times in ((0.2, 10), (0.9, 6)):
        part = exact[2] < least
        assert off(tangents.normals[:, part], exact[:, part]) < off(normals[:, part], exact[:, part]) / times
    np.testing.assert_allclose(np.linalg.norm(tangents.normals, axis=0), 1, rtol=1e-12)


def test_the_normals_of_a_leaning_wave_converge_with_the_third_power_at_least():
    errors = []
    for quads in (64, 128):
        positions, normals, triangles, exact = wave(quads)
        inner = np.abs(positions[1]) < 1.2
        errors.append(off(found(positions, normals, triangles).normals[:, inner], exact[:, inner]))
    assert errors[0] > 8 * errors[1]


def test_a_turned_wave_is_the_same_wave():
    positions, normals, triangles, _ = wave(32)
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    turn *= np.linalg.det(turn)
    one, other = found(positions, normals, triangles), found(turn @ positions, turn @ normals, triangles)
    np.testing.assert_allclose(turn @ one.normals, other.normals, atol=1e-6)
    np.testing.assert_allclose(np.einsum("ij,jkn,lk->iln", turn, one.turns, turn), other.turns, atol=1e-4)


def ball(rings=24, radius=2.0):
    """Part of a sphere, as a grid of longitudes and latitudes."""
    u, v, triangles = grid(rings, 2.0)
    n = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])
    return radius * n, n, triangles


def test_a_ball_has_its_curvature_everywhere():
    """The normal of a sphere of radius r turns by a step / r, in all directions alike."""
    positions, exact, triangles = ball()
    tangents = found(positions, shaded(positions, triangles), triangles)
    inner = np.hypot(*grid(24, 2.0)[:2]) < 0.8
    assert off(tangents.normals[:, inner], exact[:, inner]) < 1e-4
    flat = np.eye(3)[:, :, None] - exact[:, None] * exact
    np.testing.assert_allclose(tangents.turns[:, :, inner], flat[:, :, inner] / 2.0, atol=5e-3)


def test_normals_that_are_held_stay():
    positions, normals, triangles, exact = wave(32)
    held = positions[1] > 0
    tangents = compact(positions, np.where(held, exact, normals), triangles, held)
    np.testing.assert_array_equal(tangents.normals[:, held], exact[:, held])


@pytest.mark.parametrize("noise", [1e-4, 1e-3])
def test_noise_is_not_followed(noise):
    assert not found(*wave(96, noise)[:3]).sound.any()


def test_creases_and_fins_and_what_touches_them_are_left_to_the_mesh():
    x, y, triangles = grid(24, 2.0)
    positions = np.stack([x, y, np.where(x > 0, 1.5 * x, 0.0)])
    tangents = found(positions, shaded(positions, triangles), triangles)
    assert not tangents.sound[np.abs(x) < 0.09].any()
    swell = np.stack([x, y, 0.1 * np.sin(3 * x) * np.cos(2 * y)])
    tip, fin = swell[:, 300:301] + [[0.0], [0.0], [0.2]], np.array([[300, 301, len(x)]])
    swell, triangles = np.concatenate([swell, tip], 1), np.concatenate([triangles, fin])
    sound = found(swell, shaded(swell, triangles), triangles).sound
    assert not sound[fin].any() and sound.sum() > 500


def test_edges_along_their_normals_and_without_length_do_no_harm():
    positions, normals, triangles, exact = wave(96)
    count = positions.shape[1]
    tip = positions[:, 40:41] + 0.1 * normals[:, 40:41]
    strange = np.array([[40, 41, count], [5000, 5000, 5001], [6000, 6001, count + 1]])
    positions = np.concatenate([positions, tip, positions[:, 6000:6001]], 1)
    normals = np.concatenate([normals, normals[:, 40:41], normals[:, 6000:6001]], 1)
    tangents = found(positions, normals, np.concatenate([triangles, strange]))
    assert np.isfinite(tangents.normals).all() and np.isfinite(tangents.turns).all()
    assert not tangents.sound[[40, 41, count]].any()
    sound = np.flatnonzero(tangents.sound[:count])
    assert len(sound) > 9000 and off(tangents.normals[:, sound], exact[:, sound]) < off(
        normals[:, sound], exact[:, sound]
    )


def test_a_plane_is_a_plane():
    x, y, triangles = grid(8, 2.0)
    positions = np.stack([x, y, 0.5 * x])
    tangents = found(positions, shaded(positions, triangles), triangles)
    np.testing.assert_allclose(tangents.turns, 0, atol=1e-9)
    np.testing.assert_allclose(tangents.normals, shaded(positions, triangles), atol=1e-9)
