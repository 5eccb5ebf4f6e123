"""Receivers with maps of different sizes have the light that each has where all maps are of its size."""

import numpy as np
import pytest
from waves import calm, five_sines, floor, pool, quad, turned

from dapple.kernels.maps.packed import packed
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import METHODS, solve
from dapple.kernels.scene import Settings

SIZES = (64, 20, 16, 36, 16)
ALIKE = {"caustic_map": 1e-2}  # which has no tolerance: its points, fewer or more, are as far apart as texels
FLUX = {"sun_map": 5e-2}  # which gives all maps together still water's light


def shelf(name, x, y, side, z):
    """A level square over the floor."""
    corner = np.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]], float)
    return quad(name, corner + np.array([x, y, z]))


def scene(shape=five_sines):
    """A floor of 4 m, two small shelves, a wall, and a shelf that reaches past the water."""
    wall = turned(quad("Wall", [[-2, -2, 0], [-2, 2, 0], [-2, 2, 1.4], [-2, -2, 1.4]]))
    receivers = [
        floor(),
        shelf("Low", 0.2, 0.3, 0.6, 0.3),
        shelf("High", -1.0, -0.8, 0.4, 0.8),
        wall,
        shelf("Out", 1.7, -1.8, 1.2, 0.5),
    ]
    return pool(shape, 48, receivers=receivers)


def charts(of, sizes):
    return tuple(rasterise(receiver, size) for receiver, size in zip(of.receivers, sizes, strict=True))


@pytest.mark.parametrize("method", METHODS)
def test_each_map_is_as_where_all_are_of_its_size(method):
    """Not to the bit: what is fine enough, over the light of all maps, is found over all of them."""
    lit, settings = scene(), Settings(method, 1e-3, surface="mesh")
    mixed = solve(lit, charts(lit, SIZES), settings)
    assert [image.shape for image in mixed.images] == [(size, size, 3) for size in SIZES]
    assert [codes.shape for codes in mixed.status] == [(size, size) for size in SIZES]
    for size in (16, 36):
        alike = solve(lit, charts(lit, (size,) * len(SIZES)), settings)
        square = np.mean([(image**2).mean() for image in alike.images])
        for k in (k for k, own in enumerate(SIZES) if own == size):
            off = ((mixed.images[k] - alike.images[k]) ** 2).mean()
            assert off <= ALIKE.get(method, 2e-3) * square, lit.receivers[k].name
            name = lit.receivers[k].name
            received = (answer.diagnostics.flux_received[name] for answer in (mixed, alike))
            np.testing.assert_allclose(*received, rtol=FLUX.get(method, 1e-2))
            assert np.mean(mixed.status[k] == alike.status[k]) > 0.98


def test_the_books_close_and_still_water_is_exact_to_the_borders():
    still = scene(calm)
    work = solve(still, charts(still, SIZES), Settings("photon_splat", 1e-4, surface="mesh")).diagnostics
    total = sum(work.flux_received.values()) + sum(work.flux_lost.values())
    np.testing.assert_allclose(total, work.flux_in, rtol=1e-6)
    alike = solve(still, charts(still, (64,) * 5), Settings("photon_splat", 1e-4, surface="mesh")).diagnostics
    for name, flux in alike.flux_received.items():
        np.testing.assert_allclose(work.flux_received[name], flux, rtol=2e-3, err_msg=name)


def test_the_texels_are_those_of_each_receiver():
    lit = scene()
    own = charts(lit, SIZES)
    sheets = packed(lit, own)
    assert len(sheets.texels) == 2, "the floor, and all others in one image"
    assert sheets.texels[0] is own[0] and sheets.scene.receivers[0] is lit.receivers[0]
    rest = sheets.texels[1]
    order = (1, 2, 3, 4)
    np.testing.assert_array_equal(rest.positions, np.concatenate([own[k].positions for k in order]))
    np.testing.assert_array_equal(rest.area, np.concatenate([own[k].area for k in order]))
    assert len(np.unique(rest.texel)) == len(rest.texel)
    # The joined receiver's own UVs say the same of each texel: it lies where they map it to.
    again = rasterise(sheets.scene.receivers[1], 64, 0)
    at = np.argsort(again.texel)[np.searchsorted(np.sort(again.texel), rest.texel)]
    np.testing.assert_allclose(again.positions[at], rest.positions, atol=1e-9)


def test_maps_of_one_size_are_left_as_they_are():
    lit = scene()
    assert packed(lit, charts(lit, (16,) * 5)) is None


def test_many_small_maps_take_few_images():
    small = [shelf(f"Stone {k}", 0.3 * (k % 12) - 1.8, 0.3 * (k // 12) - 1.8, 0.2, 0.1) for k in range(144)]
    lit = pool(five_sines, 24, receivers=[floor(), *small])
    sheets = packed(lit, charts(lit, (256, *(16,) * 144)))
    assert [own.resolution for own in sheets.texels] == [256, 256]
    answer = solve(lit, charts(lit, (256, *(16,) * 144)), Settings("photon_splat", 1e-2, surface="mesh"))
    assert len(answer.images) == 145 and all(image.any() for image in answer.images)


def test_maps_for_cycles_are_scaled_and_the_books_are_not():
    lit, asked = scene(calm), Settings("photon_splat", 1e-2, surface="mesh", match_cycles=True)
    scaled = solve(lit, charts(lit, SIZES), asked)
    plain = solve(lit, charts(lit, SIZES), Settings("photon_splat", 1e-2, surface="mesh"))
    np.testing.assert_allclose(scaled.images[1], plain.images[1] / 1.333**2, rtol=1e-6)
    for name, flux in plain.diagnostics.flux_received.items():
        np.testing.assert_allclose(scaled.diagnostics.flux_received[name], flux, rtol=1e-9)
