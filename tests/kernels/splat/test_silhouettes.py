"""No beam that is called clear hides anything between its rays."""

import numpy as np
import pytest
from waves import five_sines, floor, quad, water

from dapple.kernels.optics import sun_frame
from dapple.kernels.rays import Tracer, soup
from dapple.kernels.splat.silhouettes import Silhouettes, lines


def post(x, y, radius, low, high, sides=6):
    """A closed prism that stands upright."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], 1)
    positions = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (low, high)] + [[[x, y, low], [x, y, high]]])
    i, j = np.arange(sides), np.roll(np.arange(sides), -1)
    side = np.concatenate([np.stack([i, j, j + sides], 1), np.stack([i, j + sides, i + sides], 1)])
    caps = np.concatenate(
        [np.stack([j, i, 0 * i + 2 * sides], 1), np.stack([i + sides, j + sides, 0 * i + 2 * sides + 1], 1)]
    )
    return type("Solid", (), {"positions": positions, "triangles": np.concatenate([side, caps])})()


def clear_of(outlines, m, direction, triangles):
    return lines(outlines.near(m, direction, triangles))


def refracted(normals, direction, eta=1.333):
    normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    c = -(normals @ direction)[..., None]
    c_t = np.sqrt(1 - (1 - c * c) / eta**2)
    return direction / eta + (c / eta - c_t) * normals


def specks(count=40):
    """Squares of a centimetre all over the pool."""
    low = np.random.default_rng(5).uniform([-1.5, -1.5, 0.2], [1.5, 1.5, 1.2], (count, 3))
    square = np.array([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]])
    return [quad("Speck", at + square) for at in low]


SCENES = {
    "posts": [floor(side=6.0), *(post(0.2 * k - 1, 0.3 * k - 1.5, 0.01, 0.0, 1.3) for k in range(9))],
    "rope": [floor(side=6.0), quad("Rope", [[-2, -1, 0.5], [2, 1, 0.8], [2, 1.005, 0.8], [-2, -0.995, 0.5]])],
    "wall along the light": [
        floor(side=6.0),
        quad("Wall", [[-1, 0.11, 0], [1.5, 0.11, 0], [1.5, 0.11, 1.2], [-1, 0.11, 1.2]]),
        quad("Wall", [[0.11, -1, 0], [0.11, 1.5, 0], [0.11, 1.5, 1.2], [0.11, -1, 1.2]]),
    ],
    "specks": [floor(side=6.0), *specks()],
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("direction", [(0.0, 0, -1), (1.0, 0, -1), (0.3, -2.0, -1)])
def test_nothing_hides_in_a_clear_beam(name, direction):
    """Rays from inside triangles of waves: what they meet and no corner does must be in beams that are not clear."""
    solids = SCENES[name]
    w, rng = water(five_sines, 96), np.random.default_rng(0)
    d = np.array(direction) / np.linalg.norm(direction)
    positions, triangles = soup(solids)
    thing = np.repeat(np.arange(len(solids)), [len(s.triangles) for s in solids])
    tracer = Tracer(positions, triangles)
    clear = clear_of(Silhouettes(positions, triangles), w.positions.T, refracted(w.normals, d).T, w.triangles)
    bary = rng.dirichlet([1, 1, 1], (len(w.triangles), 24))
    bary[:, :3] = np.eye(3)
    m = np.einsum("tsk,tkx->tsx", bary, w.positions[w.triangles])
    t = refracted(np.einsum("tsk,tkx->tsx", bary, w.normals[w.triangles]), d)
    hit = tracer.first(m.reshape(-1, 3), t.reshape(-1, 3)).reshape(len(m), -1)
    seen = np.where(hit < 0, -1, thing[hit])
    hidden = (seen[:, :3] == seen[:, :1]).all(1) & (seen != seen[:, :1]).any(1)
    assert hidden.sum() > 5
    assert not (hidden & clear).any()
    assert clear.mean() > 0.7, "doubting everything is safe but useless"


def test_nothing_hides_above_the_water():
    """The same for the leg to the sun."""
    rope = quad("Rope", [[-2, -1, 1.9], [2, 1, 2.2], [2, 1.005, 2.2], [-2, -0.995, 1.9]])
    w, rng = water(five_sines, 96), np.random.default_rng(0)
    s = sun_frame(np.array([0.3, 0.2, -1]) / np.sqrt(1.13))[2]
    clear = clear_of(
        Silhouettes(rope.positions, rope.triangles), w.positions.T, np.tile(s[:, None], len(w.positions)), w.triangles
    )
    m = np.einsum("tsk,tkx->tsx", rng.dirichlet([1, 1, 1], (len(w.triangles), 24)), w.positions[w.triangles])
    rays = np.broadcast_to(s, m.shape).reshape(-1, 3)
    hit = Tracer(rope.positions, rope.triangles).blocked(m.reshape(-1, 3), rays).reshape(len(m), -1).any(1)
    assert hit.sum() > 50
    assert not (hit & clear).any() and clear.mean() > 0.9


def test_inner_edges_of_a_smooth_surface_are_no_outlines():
    """A bowl of many triangles that all face the light has its rim as only outline."""
    x, y = np.meshgrid(np.linspace(-3, 3, 31), np.linspace(-3, 3, 31))
    i = np.arange(31 * 30).reshape(30, 31)[:, :-1].ravel()
    corner = np.stack([i, i + 1, i + 32, i + 31], 1)
    positions = np.stack([x.ravel(), y.ravel(), 0.05 * (x**2 + y**2).ravel() - 0.5], 1)
    bowl = Silhouettes(positions, corner[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))
    w = water(five_sines, 32, side=3.0)
    ray = refracted(w.normals, np.array([0, 0, -1.0])).T
    assert clear_of(bowl, w.positions.T, ray, w.triangles).all()
    assert len(bowl._outlines(ray)) == 4 * 30


def test_nothing_to_hide():
    w = water(five_sines, 4)
    empty = Silhouettes(np.zeros((0, 3)), np.zeros((0, 3), int))
    assert clear_of(empty, w.positions.T, -w.normals.T, w.triangles).all()
