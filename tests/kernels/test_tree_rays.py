"""The tracer in numpy: what it meets, against embreex and against all triangles one by one; and that it serves."""

import subprocess
import sys

import numpy as np
import pytest
from waves import floor, pool

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.rays import Tracer, soup
from dapple.kernels.scene import Occluder, Settings
from dapple.kernels.tree_rays import MISS, TreeScene


def random_soup(rng, count):
    """Triangles of many sizes in a cube: positions (3T,3), triangles (T,3)."""
    middle = rng.uniform(-1, 1, (count, 1, 3))
    size = 10 ** rng.uniform(-3, 0, (count, 1, 1))
    return (middle + size * rng.normal(size=(count, 3, 3))).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def random_rays(rng, count):
    direction = rng.normal(size=(count, 3))
    return rng.uniform(-1.5, 1.5, (count, 3)), direction / np.linalg.norm(direction, axis=1, keepdims=True)


def nearest_by_brute_force(positions, triangles, origin, direction):
    """Index of the first triangle that one ray meets, and its distance, by solving for each triangle."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    matrix = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], 2)
    u, v, t = np.linalg.solve(matrix, (origin - a)[:, :, None])[:, :, 0].T
    t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0), t, np.inf)
    return (int(t.argmin()), t.min()) if np.isfinite(t.min()) else (MISS, np.inf)


@pytest.mark.parametrize("count", [1, 3, 4, 5, 37, 500])
def test_first_triangle_by_brute_force(count):
    rng = np.random.default_rng(count)
    positions, triangles = random_soup(rng, count)
    origins, directions = random_rays(rng, 300)
    wanted = [nearest_by_brute_force(positions, triangles, *ray)[0] for ray in zip(origins, directions)]
    assert TreeScene(positions, triangles).run(origins, directions).tolist() == wanted
    assert np.count_nonzero(np.array(wanted) != MISS) > 100 or count < 500


def test_as_embreex_within_distances():
    rng = np.random.default_rng(2)
    positions, triangles = random_soup(rng, 3000)
    origins, directions = random_rays(rng, 10000)
    tracer, tree = Tracer(positions, triangles), TreeScene(positions, triangles)
    hit, own = tracer.first(origins, directions), tree.run(origins, directions)
    assert np.count_nonzero(hit != own) <= 2  # embree rounds to float32
    assert np.count_nonzero(own != MISS) > 1000
    far = rng.uniform(0.1, 3, len(origins))
    occluded = tree.run(origins, directions, far, "OCCLUDED") != MISS
    assert np.count_nonzero(occluded != tracer.blocked(origins, directions, far)) <= 2
    assert 0 < np.count_nonzero(occluded) < np.count_nonzero(own != MISS)


def test_no_ray_slips_through_edges_or_runs_along_a_box():
    positions, triangles = soup([floor(z=0.0)])
    tree = TreeScene(positions, triangles)
    along = np.linspace(0.01, 0.99, 101)[:, None]
    above = np.concatenate([p + (q - p) * along for p in positions for q in positions]) + np.array([0, 0, 1.0])
    assert (tree.run(above, np.tile([0, 0, -1.0], (len(above), 1))) != MISS).all()
    past = np.array([[-9.0, 0.0, 0.5], [0.0, 9.0, 1e-3]])
    assert tree.run(past, np.array([[1.0, 0, 0], [0, -1.0, 0]])).tolist() == [MISS, MISS]


WITHOUT = """
import runpy, sys
sys.modules["embreex"] = None
runpy.run_path({conftest!r})
sys.path.insert(0, {tests!r})
solution = runpy.run_path({file!r})["shaded_pool"]()
print(solution.diagnostics.slow_rays)
import numpy as np
np.save({out!r}, solution.images[0])
"""


def shaded_pool():
    """The Solution of a pool with a raft above the water, whose shadow needs rays."""
    scene = pool(quads=24, occluders=[Occluder("Raft", *soup([floor(side=1.0, z=2.0)]))])
    return solve(scene, [rasterise(scene.receivers[0], 32)], Settings(resolution=32))


def test_a_bake_without_embreex(root, tmp_path):
    out = tmp_path / "image.npy"
    words = {
        "conftest": str(root / "tests" / "conftest.py"),
        "tests": str(root / "tests"),
        "file": __file__,
        "out": str(out),
    }
    run = subprocess.run([sys.executable, "-c", WITHOUT.format(**words)], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "embreex does not load here" in run.stdout
    with_embreex = shaded_pool()
    assert with_embreex.diagnostics.slow_rays == ""
    image, wanted = np.load(out), with_embreex.images[0]
    assert np.count_nonzero(wanted.sum(2) < 0.1) > 20  # the shadow
    np.testing.assert_allclose(image, wanted, atol=1e-3 * wanted.mean())
