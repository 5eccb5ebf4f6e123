"""Charts are a matter of storage: the light on a sphere or a cylinder is the same in one chart and in several."""

import numpy as np
import pytest
from waves import OBLIQUE, calm, five_sines, flat, floor, pool, transmitted

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Receiver, Settings

SIDE = 96
CENTRE, RADIUS = np.array([0.2, -0.1, 0.6]), 0.5
AROUND, ALONG = 96, 48  # quads of the sphere


def sphere():
    """Vertices, triangles and angles of corners (T,3,2), azimuth and from the top, of a sphere; no triangle is flat."""
    azimuth, polar = np.arange(AROUND) * 2 * np.pi / AROUND, np.arange(ALONG + 1) * np.pi / ALONG
    ring = np.stack([np.cos(azimuth), np.sin(azimuth)], 1)
    points = np.concatenate([np.column_stack([np.sin(p) * ring, np.full(AROUND, np.cos(p))]) for p in polar])
    k, j = np.meshgrid(np.arange(ALONG), np.arange(AROUND), indexing="ij")
    corner = [(k, j), (k + 1, j), (k + 1, j + 1), (k, j + 1)]
    triangles, angles = [], []
    for chosen, keep in (((0, 1, 2), k < ALONG - 1), ((0, 2, 3), k > 0)):
        rows = [np.stack(corner[c], -1)[keep] for c in chosen]
        triangles.append(np.stack([a * AROUND + b % AROUND for a, b in np.moveaxis(rows, -1, 1)], 1))
        angles.append(np.stack([np.stack([b * 2 * np.pi / AROUND, a * np.pi / ALONG], 1) for a, b in
                                np.moveaxis(rows, -1, 1)], 1))  # fmt: skip
    return points, np.concatenate(triangles), np.concatenate(angles)


def in_one_chart():
    """The sphere cut along a meridian, azimuth by polar angle."""
    points, triangles, angles = sphere()
    uvs = angles / [2 * np.pi, -np.pi] + [0, 1]
    return Receiver("Sphere", CENTRE + RADIUS * points, triangles, 0.02 + 0.96 * uvs)


def in_six_charts():
    """The same triangles, each by central projection on the side of a cube that its middle is nearest to."""
    points, triangles, _ = sphere()
    corner = points[triangles]
    middle = corner.mean(1)
    axis = np.abs(middle).argmax(1)
    positive = np.take_along_axis(middle, axis[:, None], 1)[:, 0] > 0
    rolled = np.stack([np.roll(c, 2 - a, axis=1) for c, a in zip(corner, axis, strict=True)])
    plane = rolled[:, :, :2] / np.abs(rolled[:, :, 2:])
    cell = np.stack([axis, positive], 1)[:, None] + 0.5
    uvs = (cell + 0.38 * plane) / [3, 2]
    return Receiver("Sphere", CENTRE + RADIUS * points, triangles, uvs)


UNWRAPPED = {"one": in_one_chart(), "six": in_six_charts()}


def bake(receiver, shape, **how):
    texels = (rasterise(receiver, SIDE), rasterise(floor(), SIDE))
    scene = pool(shape, 64, receivers=[receiver, floor()])
    return texels, solve(scene, texels, Settings(tolerance=1e-3, surface="mesh", **how))


def on_border(own):
    """Whether (K,) texels have neighbours off their chart."""
    row, column = np.divmod(own.texel, SIDE)
    chart = np.full((SIDE + 2, SIDE + 2), -1)
    chart[row + 1, column + 1] = own.chart[own.triangle]
    steps = [(1, 0), (-1, 0), (0, 1), (0, -1)]
    return np.any([chart[row + 1 + j, column + 1 + i] != own.chart[own.triangle] for j, i in steps], axis=0)


def test_the_unwrapped_have_the_charts_that_they_say():
    assert [rasterise(r, SIDE).chart.max() + 1 for r in UNWRAPPED.values()] == [1, 6]


@pytest.mark.parametrize("charts", UNWRAPPED)
@pytest.mark.parametrize("how", [{}, {"method": "conic_walk"}], ids=["beams", "walk"])
def test_still_water_lights_a_sphere_by_its_slant(charts, how):
    """E = T cos_i / cos_t max(0, -n.t) of parallel light, at borders of charts as elsewhere."""
    (own, _), answer = bake(UNWRAPPED[charts], flat, **how)
    d = np.array(OBLIQUE) / np.linalg.norm(OBLIQUE)
    cos_t = np.sqrt(1 - (1 - d[2] ** 2) / 1.333**2)
    t = np.array([*d[:2] / 1.333, -cos_t])
    normal = (own.positions - CENTRE) / RADIUS
    expected = transmitted(-d[2]) * -d[2] / cos_t * np.maximum(-(normal @ t), 0)
    got = answer.images[0].reshape(-1, 3)[own.texel, 0]
    sound = own.area > 0.3 * np.median(own.area)  # at the poles of a map a texel is a sliver
    clear = sound & (np.abs(normal @ t) > 0.15)  # the facets of its rim shade and show each other
    for some, off in ((clear & on_border(own), 0.05), (clear & ~on_border(own), 0.02)):
        assert some.sum() > 100
        assert np.sqrt((own.area[some] @ (got - expected)[some] ** 2) / own.area[some].sum()) < 0.04
        assert own.area[some] @ got[some] == pytest.approx(own.area[some] @ expected[some], rel=off)


@pytest.mark.parametrize("shape", [calm, five_sines])
def test_waves_leave_the_same_light_in_one_chart_and_in_six(shape):
    """Moments of the light over the sphere, and what its shadow leaves: nothing is lost or counted twice at a seam."""
    found = {}
    for charts, receiver in UNWRAPPED.items():
        (own, _), answer = bake(receiver, shape)
        x, y, z = ((own.positions - CENTRE) / RADIUS).T
        moments = np.stack([x**a * y**b * z**c for a in range(4) for b in range(4) for c in range(4)])
        light = answer.images[0].reshape(-1, 3)[own.texel, 0]
        found[charts] = moments @ (own.area * light), answer.diagnostics
    (one, books), (six, others) = found["one"], found["six"]
    assert one[0] == pytest.approx(six[0], rel=3e-3)
    np.testing.assert_allclose(one, six, atol=3e-3 * one[0])
    np.testing.assert_allclose(books.flux_received["Floor"], others.flux_received["Floor"], rtol=2e-3)
    for work in (books, others):
        total = sum(work.flux_received.values()) + sum(work.flux_lost.values())
        np.testing.assert_allclose(total, work.flux_in, rtol=1e-9)


def stairs():
    """Two treads with a riser between them that looks away from the sun, unwrapped as one strip along u."""
    profile = np.array([[-2, 0.9], [0, 0.9], [0, 0.3], [2, 0.3]])  # x, z
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    positions = np.concatenate([[[x, -2, z], [x, 2, z]] for x, z in profile])
    quads = np.array([[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(3)])
    triangles = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    uvs = np.stack([np.repeat(along / along[-1], 2), np.tile([0.0, 1.0], 4)], 1)[triangles]
    return Receiver("Stairs", positions, triangles, uvs)


@pytest.mark.parametrize("points", [False, True], ids=["beams", "points"])
def test_a_step_in_one_chart_leaves_its_riser_dark(points):
    """Light jumps in the map from the upper tread over the riser, which looks away, to where it meets the lower one."""
    scene = pool(flat, 32, (-0.6, 0.0, -1.0), [stairs()])
    own = rasterise(stairs(), 2 * SIDE)
    back = pool(flat, 32, (0.6, 0.0, -1.0), [stairs()])
    riser = own.normals[:, 0] > 0.5
    lit, dark = (
        solve(s, (own,), Settings(tolerance=1e-3, points=points, surface="mesh")).images[0].reshape(-1, 3)[own.texel]
        for s in (scene, back)
    )
    assert riser.sum() > 500
    assert lit[riser].mean() > 0.3
    assert dark[riser & (np.abs(own.positions[:, 2] - 0.6) < 0.25)].max() == 0.0
