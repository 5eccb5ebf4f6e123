"""Light that meets the water again, by hand-made constructions and against rays cast at everything."""

import numpy as np
import pytest
from waves import five_sines, flat, floor, grid, sun, water

from dapple.kernels.halfedges import build_twins
from dapple.kernels.rays import MISS, Tracer, soup
from dapple.kernels.sources import Parallel
from dapple.kernels.splat.meetings import HISTORIES, Meetings

ETA = 1.333


def meetings(positions, triangles, normals=None, solids=()):
    """Meetings of flat-shaded triangles, or with normals per vertex."""
    v = positions[triangles]
    facet = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    rows = np.repeat(np.arange(len(facet))[:, None], 3, 1)
    shading = (facet, rows) if normals is None else (normals, triangles)
    return Meetings(positions, shading[0], triangles, shading[1], build_twins(triangles), Tracer(*soup(solids)), ETA)


def of(w, solids=()):
    return Meetings(w.positions, w.normals, w.triangles, w.normal_triangles, w.twins, Tracer(*soup(solids)), ETA)


def fine(positions, triangles, times=4):
    """The same surface in triangles a sixteenth of the edge."""
    for _ in range(times):
        v = positions[triangles]
        middle = (v + np.roll(v, -1, axis=1)) / 2
        a, b, c = v[:, 0], v[:, 1], v[:, 2]
        ab, bc, ca = middle[:, 0], middle[:, 1], middle[:, 2]
        parts = np.concatenate([np.stack(p, 1) for p in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        positions, triangles = np.unique(parts.reshape(-1, 3).round(12), axis=0, return_inverse=True)
        triangles = triangles.reshape(-1, 3)
    return positions, triangles


def box(low=(-1, -1, 0), high=(1, 1, 1)):
    """A closed box of water, its triangles wound outwards."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    triangles = np.array([[[q[0], q[1], q[2]], [q[0], q[2], q[3]]] for q in quads]).reshape(-1, 3)
    return fine(np.asarray(low) + corners * np.subtract(high, low), triangles)


def never(m, towards):
    """`Meetings.never` for a sun that is `towards` (3,1) the water."""
    return m.never(Parallel(sun(-towards[:, 0])))


def rows(*vectors):
    return np.array(vectors, float).T


def normal_passes():
    return 1 - ((ETA - 1) / (ETA + 1)) ** 2


def test_light_leaves_a_tank_by_its_bottom():
    m = meetings(*box())
    rays = m.follow(rows((0.3, 0.2, 1.0)), rows((0, 0, -1)), inside=True)
    np.testing.assert_allclose(rays.origin[:, 0], [0.3, 0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(rays.direction[:, 0], [0, 0, -1], atol=1e-12)
    assert rays.share[0] == pytest.approx(normal_passes(), rel=1e-12)
    assert rays.wet[0] == pytest.approx(1.0) and not rays.inside[0] and rays.history[0] > 0 and not rays.trapped[0]


def test_light_leaves_by_the_bottom_as_it_came_in_by_the_top():
    """Two parallel faces: what leaves travels as what came, with the transmittance of the way in."""
    slant = np.radians(35)
    bent = np.arcsin(np.sin(slant) / ETA)
    rays = meetings(*box()).follow(rows((-0.3, 0.1, 1.0)), rows((np.sin(bent), 0, -np.cos(bent))), inside=True)
    np.testing.assert_allclose(rays.direction[:, 0], [np.sin(slant), 0, -np.cos(slant)], atol=1e-12)
    s, p = np.sin(slant - bent) / np.sin(slant + bent), np.tan(slant - bent) / np.tan(slant + bent)
    assert rays.share[0] == pytest.approx(1 - (s * s + p * p) / 2, rel=1e-12)


def test_a_side_turns_all_light_back_beyond_the_critical_angle():
    """Down at 40 degrees, the side is met at 50, beyond 48.6: all is turned, and leaves by the bottom, mirrored."""
    bent = np.radians(40)
    rays = meetings(*box()).follow(rows((0.8, 0, 1.0)), rows((np.sin(bent), 0, -np.cos(bent))), inside=True)
    out = np.arcsin(ETA * np.sin(bent))
    np.testing.assert_allclose(rays.direction[:, 0], [-np.sin(out), 0, -np.cos(out)], atol=1e-12)
    across = np.tan(bent) - 0.2
    np.testing.assert_allclose(rays.origin[:, 0], [1 - across, 0, 0], atol=1e-12)
    assert rays.wet[0] == pytest.approx(1 / np.cos(bent)) and 0.8 < rays.share[0] < 1
    straight = meetings(*box()).follow(rows((0.0, 0, 1.0)), rows((np.sin(bent), 0, -np.cos(bent))), inside=True)
    assert straight.history[0] != rays.history[0], "other ways have other numbers"


def test_a_solid_in_the_tank_ends_the_ray_first():
    rays = meetings(*box(), solids=(floor(side=1.0, z=0.5),)).follow(
        rows((0.3, 0.2, 1.0), (0.7, 0.2, 1.0)), rows((0, 0, -1), (0, 0, -1)), inside=True
    )
    assert rays.history[0] == 0 and rays.share[0] == 1 and rays.inside[0] and rays.wet[0] == 0
    assert rays.history[1] > 0


def ridge(slope=3.0, half=0.2, far=3.0, bank=False):
    """Still water at z = 0 with one ridge along y, of straight sides; as a bank, it stays high behind its crest."""
    x = np.unique(np.concatenate([np.linspace(-far, far, 61), np.linspace(-half, half, 41)]))
    y = np.linspace(-1, 1, 11)
    gx, gy = np.meshgrid(x, y)
    i = np.arange(len(x) * (len(y) - 1)).reshape(len(y) - 1, len(x))[:, :-1].ravel()
    quad = np.stack([i, i + 1, i + len(x) + 1, i + len(x)], 1)
    height = slope * np.maximum(half - np.abs(np.minimum(gx, 0) if bank else gx), 0)
    return np.stack([gx.ravel(), gy.ravel(), height.ravel()], 1), quad[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def test_a_ridge_casts_its_shadow_on_the_water_behind():
    """0.6 m high, light at 20 degrees from -x: the shadow ends 0.6 / tan(20) behind the crest."""
    m = meetings(*ridge())
    rise = np.radians(20)
    end = 0.6 / np.tan(rise)
    points = rows((-1, 0.1, 0), (-0.1, 0.1, 0.3), (0.5, 0.1, 0), (end - 0.05, 0.1, 0), (end + 0.05, 0.1, 0))
    shaded = m.shaded(points, rows((-np.cos(rise), 0, np.sin(rise))))
    np.testing.assert_array_equal(shaded, [False, False, True, True, False])
    assert not m.shaded(points, rows((0, 0, 1))).any()


def test_a_reflected_ray_enters_the_next_wave():
    """Level light meets the ridge's side, 71.6 degrees steep: in by Snell's law about that side's normal."""
    m = meetings(*ridge(bank=True))
    rays = m.follow(rows((-1.0, 0.05, 0.3)), rows((1, 0, 0)), inside=False)
    np.testing.assert_allclose(rays.origin[:, 0], [-0.1, 0.05, 0.3], atol=1e-9)
    n = np.array([-3, 0, 1]) / np.sqrt(10)
    assert rays.inside[0] and rays.wet[0] == 0
    t = rays.direction[:, 0]
    assert np.linalg.norm(t) == pytest.approx(1)
    np.testing.assert_allclose(ETA * np.cross(n, t), np.cross(n, [1, 0, 0]), atol=1e-12)
    assert t @ n < 0


def test_light_that_bounces_on_is_trapped_in_the_end():
    """Between two upright sides at grazing angles light runs down a deep slit; what does not end is said to be."""
    positions, triangles = box((-0.02, -1, -50), (0.02, 1, 1))
    bent = np.radians(30)
    rays = meetings(positions, triangles).follow(rows((0, 0, 0.9)), rows((np.sin(bent), 0, -np.cos(bent))), inside=True)
    assert rays.trapped[0] and rays.share[0] == 1 and rays.history[0] < HISTORIES


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_what_is_called_impossible_never_happens(scale):
    """Any direction from any point of waves: rays into the water that come to it from within, and rays off it that come
    to it from without, are all among those that the slopes allow."""
    w = water(lambda x, y: five_sines(x, y, scale), 60)
    m, tracer, rng = of(w), Tracer(w.positions, w.triangles), np.random.default_rng(1)
    bary, t = rng.dirichlet([1, 1, 1], 20000), rng.integers(0, len(w.triangles), 20000)
    points = (bary[:, :, None] * w.positions[w.triangles[t]]).sum(1)
    ray = rng.normal(size=(20000, 3))
    ray /= np.linalg.norm(ray, axis=1, keepdims=True)
    hit = tracer.first(points + 0.1 * ray, ray)
    v = w.positions[w.triangles[hit]]
    along = (np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]) * ray).sum(1)
    real = (hit != MISS) & (along * ray[:, 2] < 0)
    assert real.sum() > 20 * scale
    possible = m.possible(ray.T)
    assert not (real & ~possible).any()
    assert possible.mean() < 0.9
    followed = np.concatenate([m.follow(points[ray[:, 2] < 0].T, ray[ray[:, 2] < 0].T, inside=True).history > 0])
    assert followed.sum() > 20


def test_a_pool_under_a_high_sun_needs_no_look():
    m = of(water(five_sines, 64))
    assert never(m, rows((0.25, 0.1, 1.0)))
    assert not never(m, rows((np.cos(0.1), 0, np.sin(0.1))))


def test_what_may_be_met_from_anywhere_is_never_ruled_out():
    """Closed, overhanging or doubled water has no height of its own at a place."""
    up = rows((0, 0, 1))
    assert not never(meetings(*box()), up)
    low = water(flat, 8, side=2.0)
    triangles = grid(8, 2.0)[2]
    both = (
        np.concatenate([low.positions, low.positions + np.array([0.5, 0, 0.3])]),
        np.concatenate([triangles, triangles + 81]),
    )
    doubled = meetings(*both)
    assert not never(doubled, up)
    shade = doubled.shaded(rows((0.6, 0.1, 1.5), (-0.8, 0.1, 1.5), (0.6, 0.1, 1.8)), up)
    np.testing.assert_array_equal(shade, [True, False, False])
    beside = np.concatenate([low.positions, low.positions + np.array([2.0, 0, 0])]), both[1]
    assert never(meetings(*beside), up)


def test_winding_does_not_matter():
    w = water(five_sines, 16)
    mixed = w.triangles.copy()
    mixed[::3] = mixed[::3, ::-1]
    m = Meetings(w.positions, w.normals, mixed, mixed, build_twins(mixed), Tracer(*soup(())), ETA)
    assert m.slope == pytest.approx(of(w).slope) and never(m, rows((0, 0, 1)))


def test_a_needle_is_as_steep_as_the_water_round_it():
    """Three corners of a gentle bowl, almost in a row in plan: their facet is upright, and no ray can use it."""
    x, y = np.array([[-0.1, 0.0, 0.1, 0.0, 0.0], [0.0, 1e-7, 0.0, -0.2, 0.2]])
    positions = np.stack([x, y, 0.5 * (x * x + y * y)], 1)
    needle = np.array([[0, 2, 1]])
    others = np.array([[0, 3, 2], [0, 1, 4], [1, 2, 4]])
    triangles = np.concatenate([others, needle])
    normals = np.stack([-x, -y, np.ones(5)], 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    facet = np.cross(*(positions[needle[0, 1:]] - positions[0]))
    assert np.hypot(*facet[:2]) > 100 * abs(facet[2])
    smooth = meetings(positions, triangles, normals)
    assert smooth.slope <= 0.5 and not smooth.steep.any()
    assert meetings(positions, triangles).slope > 100, "flat shading means the facet"
