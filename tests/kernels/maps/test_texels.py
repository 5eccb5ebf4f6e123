"""Texels against rectangles and curved meshes whose areas and positions are known."""

import numpy as np
import pytest
from waves import floor, grid, quad

from dapple.kernels.maps.texels import UVError, rasterise
from dapple.kernels.scene import Receiver


def test_full_chart_has_a_texel_everywhere_at_its_centre():
    texels = rasterise(floor(side=4.0), 16)
    assert len(texels.texel) == 256
    row, column = np.divmod(texels.texel, 16)
    expected = np.stack([(column + 0.5) / 4 - 2, (row + 0.5) / 4 - 2, 0 * row], 1)
    np.testing.assert_allclose(texels.positions, expected, atol=1e-12)
    np.testing.assert_allclose(texels.area, 1 / 16, atol=1e-12)
    np.testing.assert_allclose(texels.normals, np.tile([0, 0, 1.0], (256, 1)))
    assert texels.whole.all()
    assert len(texels.pad_texel) == 0


def test_slivers_join_a_neighbour_with_their_area():
    # 0.3 of a texel hangs over each border of a chart of 4.6 texels.
    texels = rasterise(
        floor(side=4.6, uv_low=(0.2 / 8 + 0.0625, 0.0625), uv_high=(0.2 / 8 + 0.0625 + 4.6 / 8, 0.0625 + 4.6 / 8)), 8
    )
    assert texels.area.sum() == pytest.approx(4.6**2, rel=1e-9)
    owned = (texels.home >= 0).reshape(8, 8)
    assert owned.any()
    assert texels.area.min() > 0.5 * (4.6 / 4.6) ** 2 * 0.9
    np.testing.assert_array_equal(np.sort(texels.home[texels.texel]), np.arange(len(texels.texel)))


def test_area_is_the_world_area_of_a_curved_mesh():
    x, y, triangles = grid(20, 2.0)
    positions = np.stack([x, y, 0.3 * np.sin(3 * x) * np.cos(2 * y)], 1)
    receiver = Receiver("Dune", positions, triangles, (np.stack([x, y], 1)[triangles] / 2 + 0.5) * 0.9 + 0.05)
    edges = positions[triangles]
    area = np.linalg.norm(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1).sum() / 2
    texels = rasterise(receiver, 128)
    assert texels.area.sum() == pytest.approx(area, rel=1e-9)
    # A texel's point lies on the triangle that owns it.
    corner = positions[triangles[texels.triangle]]
    height = ((texels.positions - corner[:, 0]) * texels.normals).sum(1)
    assert np.abs(height).max() < 1e-12


def test_padding_copies_the_border_and_nothing_else():
    texels = rasterise(floor(uv_low=(0.25, 0.25), uv_high=(0.75, 0.75)), 32, padding=3)
    image = texels.image(texels.positions[:, 0])
    lit = np.zeros((32, 32), bool)
    lit.flat[texels.texel] = True
    padded = np.zeros((32, 32), bool)
    padded.flat[texels.pad_texel] = True
    assert lit[8:24, 8:24].all() and lit.sum() == 256
    assert padded[5:27, 5:27].sum() == 22 * 22 - 256 and padded.sum() == 22 * 22 - 256
    np.testing.assert_array_equal(image[10, 5:8], image[10, 8])
    np.testing.assert_array_equal(image[10, 24:27], image[10, 23])
    assert (image[:5] == 0).all()


def test_bilinear_look_up_at_a_charts_border_sees_only_its_own_light():
    # Light 1 everywhere: without padding a look-up on the border would blend with black.
    texels = rasterise(floor(uv_low=(0.21, 0.33), uv_high=(0.77, 0.71)), 64, padding=2)
    image = texels.image(np.ones(len(texels.texel)))
    u = np.linspace(0.21, 0.77, 301) * 64 - 0.5
    for v in (0.33 * 64 - 0.5, 0.71 * 64 - 0.5):
        j, i = int(np.floor(v)), np.floor(u).astype(int)
        corners = np.stack([image[j, i], image[j, i + 1], image[j + 1, i], image[j + 1, i + 1]])
        assert (corners == 1).all()


def test_two_charts_keep_apart():
    one = quad("One", [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], (0.0, 0.0), (0.45, 1.0))
    two = quad("Two", [[5, 0, 0], [6, 0, 0], [6, 1, 0], [5, 1, 0]], (0.55, 0.0), (1.0, 1.0))
    both = Receiver(
        "Both",
        np.concatenate([one.positions, two.positions]),
        np.concatenate([one.triangles, two.triangles + 4]),
        np.concatenate([one.uvs, two.uvs]),
    )
    texels = rasterise(both, 64, padding=8)
    image = texels.image(texels.positions[:, 0] > 3)
    assert not image[:, :31].any() and image[:, 33:].all()
    assert texels.area.sum() == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda uv: uv * np.nan, "not numbers"),
        (lambda uv: uv * 1.5, "leaves the unit square"),
        (lambda uv: uv * 0, "has no area"),
        (lambda uv: np.concatenate([uv[:1], uv[:1]]), "overlap"),
    ],
)
def test_uvs_that_cannot_carry_a_map_say_why(change, sentence):
    receiver = floor()
    bad = Receiver("Bad", receiver.positions, receiver.triangles, change(receiver.uvs))
    with pytest.raises(UVError, match=sentence):
        rasterise(bad, 32)


def test_mirrored_uvs_are_as_good():
    receiver = floor()
    mirrored = Receiver("Mirrored", receiver.positions, receiver.triangles, receiver.uvs * [-1, 1] + [1, 0])
    texels = rasterise(mirrored, 16)
    assert texels.area.sum() == pytest.approx(16.0)
    assert texels.positions[0][0] == pytest.approx(2 - 0.125)
