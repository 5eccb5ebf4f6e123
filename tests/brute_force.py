"""Every refracted path to a point by brute force, for scenes of a few hundred triangles."""

import numpy as np

from dapple.kernels.lit_water import light_water
from dapple.kernels.walk.conic import is_path
from dapple.kernels.walk.lit_surface import Surface


def all_roots(scene, points, samples=24):
    """Every refracted path to each of points (n,3), by Newton's method from many starts in every triangle."""
    lit = light_water(scene.water, scene.lights[0])
    surface = Surface(lit, scene.water.twins)
    eta, found = scene.eta, []
    count = len(scene.water.triangles)
    side = int(np.sqrt(samples))
    a, b = (np.indices((side, side)).reshape(2, -1) + 0.5) / side
    a, b = a[a + b < 1], b[a + b < 1]
    starts = np.array([(1 - u - v, u, v) for u, v in zip(a, b, strict=True)])
    for point in points:
        p = (lit.frame @ point)[:, None]
        triangle = np.repeat(np.arange(count), len(starts))
        weights = np.tile(starts, (count, 1))
        for _ in range(30):
            base = _mismatch(surface, triangle, weights, p, eta)
            step = 1e-7
            along = [
                _mismatch(surface, triangle, weights + step * np.array(d), p, eta) for d in ([-1, 1, 0], [-1, 0, 1])
            ]
            j = [(x - base) / step for x in along]
            det = j[0][0] * j[1][1] - j[0][1] * j[1][0]
            det = np.where(np.abs(det) < 1e-30, 1e-30, det)
            da = -(base[0] * j[1][1] - base[1] * j[1][0]) / det
            db = -(j[0][0] * base[1] - j[0][1] * base[0]) / det
            da, db = np.clip([da, db], -0.5, 0.5)
            weights = weights + np.stack([-da - db, da, db], 1)
        m, n = surface.at(triangle, weights)
        good = is_path(m, n, np.broadcast_to(p, (3, len(triangle))), eta) & (weights.min(1) > -1e-7)
        unique = {(t, *np.round(w, 5)) for t, w in zip(triangle[good], weights[good], strict=True)}
        found.append(np.array(sorted(unique)).reshape(-1, 4))
    return found


def _mismatch(surface, triangle, weights, p, eta):
    m, n = surface.at(triangle, weights)
    w = [p[i] - m[i] for i in range(3)]
    length = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
    u = [c / length for c in w]
    return np.stack([n[i] * (-eta * u[2] - 1) + eta * n[2] * u[i] for i in (0, 1)])
