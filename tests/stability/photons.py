"""Brute force, for comparison: millions of points on the water, each refracted by Snell's law and traced to the nearest
triangle of any object by testing all of them. Shares no code with the kernels, and knows its own noise."""

from dataclasses import dataclass

import numpy as np

_EPS = 1e-9  # of a ray's length: what it starts on does not stop it


@dataclass(frozen=True)
class Expected:
    """What a map should hold: mean (H,W) irradiance of each receiver's texels and its standard error (H,W)."""

    images: tuple[np.ndarray, ...]
    errors: tuple[np.ndarray, ...]


def constant(values, resolution):
    """Expected of closed forms: a number per receiver, or an (H,W) array, known without error."""
    images = tuple(np.broadcast_to(np.asarray(v, float), (resolution, resolution)) for v in values)
    return Expected(images, tuple(np.zeros_like(image) for image in images))


def trace(scene, resolution, photons=150_000, seed=0, water_shades=False, again=None):
    """Expected of a Scene under its one sun, by about `photons` stratified points in each of two independent draws.

    Receivers must be planar, with charts that end on texels' borders. A facet is lit where its interpolated normal
    faces the sun. water_shades: water that stands between the sun and water blocks it. again: what the water reflects,
    and what meets it again farther than `again` [m] on, is followed, both what passes and what is turned back.
    """
    draws = [_draw(scene, resolution, photons, np.random.default_rng([seed, k]), water_shades, again) for k in (0, 1)]
    images = tuple((a + b) / 2 for a, b in zip(*draws, strict=True))
    return Expected(images, tuple(np.abs(a - b) / 2 for a, b in zip(*draws, strict=True)))


def _draw(scene, resolution, photons, rng, water_shades, again):
    """Images (H,W) of all receivers from one draw."""
    d = np.asarray(scene.lights[0].direction, float)
    m, n, flux = _points(scene.water, d, photons, rng)
    t, passed = refract(d, n, scene.eta)
    solids = [s.positions[s.triangles] for s in (*scene.receivers, *scene.occluders)]
    shades = [*solids, scene.water.positions[scene.water.triangles]] if water_shades else solids
    lowest = (m @ -d).min()
    shades = [solid[(solid @ -d).max(1) > lowest] for solid in shades]
    shadowed = np.isfinite(_nearest(m, -d[None], shades)[0])
    flux = np.where(shadowed, 0.0, flux)
    if again is None:
        _, owner, triangle, bary = _nearest(m, t, solids)
        flux = flux * passed
    else:
        owner, triangle, bary, flux = _follow_all(scene, solids, m, n, d, flux, again)
    images = []
    for k, receiver in enumerate(scene.receivers):
        on = np.flatnonzero((owner == k) & (flux > 0))
        uv = (bary[on, :, None] * receiver.uvs[triangle[on]]).sum(1) * resolution
        cell = np.clip(uv, 0, resolution - 1).astype(int)
        share = flux[on] / _texel_area(receiver, resolution)[triangle[on]]
        flat = np.bincount(cell[:, 1] * resolution + cell[:, 0], share, resolution**2)
        images.append(flat.reshape(resolution, resolution))
    return images


def _follow_all(scene, solids, m, n, d, flux, near):
    """Solid (k,), triangle, barycentrics and flux of all light that arrives of photons m, n that come along d, each
    branched at every meeting with the water into what passes and what is turned back."""
    w = scene.water
    soup, shading = w.positions[w.triangles], w.normals[w.normal_triangles]
    outward = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    outward *= np.sign((outward * shading.sum(1)).sum(1))[:, None]
    lit = np.flatnonzero((flux > 0) & (n @ d < 0))
    rays = _branch(m[lit], np.tile(d, (len(lit), 1)), n[lit], flux[lit], np.zeros(len(lit), bool), scene.eta)
    found, least = [], 1e-3 * flux.max()
    for _ in range(8):
        m, t, flux, inside = (v[rays[2] > least] for v in rays)
        if not len(m):
            break
        far, owner, triangle, bary = _nearest(m, t, solids)
        to_water, _, facet, weights = _nearest(m + near * t, t, [soup])
        to_water += near
        lands = np.flatnonzero((far < to_water) & (owner >= 0))
        found.append((owner[lands], triangle[lands], bary[lands], flux[lands]))
        at = np.flatnonzero(to_water < far)
        point = m[at] + to_water[at, None] * t[at]
        leaves = (outward[facet[at]] * t[at]).sum(1) > 0
        real = leaves == inside[at]
        normal = (weights[at, :, None] * shading[facet[at]]).sum(1)
        turned = at[real]
        branches = _branch(point[real], t[turned], normal[real], flux[turned], inside[turned], scene.eta)
        past = at[~real]
        straight = point[~real], t[past], flux[past], inside[past]
        rays = [np.concatenate(pair) for pair in zip(branches, straight, strict=True)]
    return [np.concatenate(part) for part in zip(*found, strict=True)]


def _branch(m, t, n, flux, inside, eta):
    """Points, directions, flux and side of the two branches of rays t (k,3) that meet water of normals n: what passes,
    then what is reflected. Refraction by the tangents' equality, Fresnel's by impedances, unlike `refract`."""
    n = n / np.linalg.norm(n, axis=1, keepdims=True)
    n = np.where((n * t).sum(1, keepdims=True) > 0, -n, n)
    c = -(n * t).sum(1)
    before, after = np.where(inside, eta, 1.0), np.where(inside, 1.0, eta)
    across = (t + c[:, None] * n) * (before / after)[:, None]
    squared = 1 - (across**2).sum(1)
    c_t = np.sqrt(np.maximum(squared, 0))
    s = (before * c - after * c_t) / (before * c + after * c_t)
    p = (after * c - before * c_t) / (after * c + before * c_t)
    turned = np.where(squared > 0, (s * s + p * p) / 2, 1.0)
    through = across - c_t[:, None] * n
    back = t + 2 * c[:, None] * n
    pairs = (m, m), (through, back), (flux * (1 - turned), flux * turned), (~inside, inside)
    return [np.concatenate(pair) for pair in pairs]


def _points(water, d, photons, rng):
    """Points m (k,3), normals n (k,3) and flux (k,) on the water, stratified in every triangle by its lit area."""
    v = water.positions[water.triangles]
    lit = np.abs(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]) @ d) / 2
    parts = np.maximum(1, np.sqrt(lit / lit.sum() * photons)).astype(int)
    position, normal, flux = [], [], []
    for count in np.unique(parts):
        group = np.flatnonzero(parts == count)
        i, j = (g.ravel() for g in np.indices((count, count)))
        a, b = (np.stack([i, j])[:, None] + rng.random((2, len(group), count**2))) / count
        over = a + b > 1  # the square's upper half folds onto the lower: still one point a cell of each half
        w = np.stack([np.where(over, 1 - a, a), np.where(over, 1 - b, b)], -1)
        w = np.concatenate([1 - w.sum(-1, keepdims=True), w], -1)
        position.append((w @ v[group]).reshape(-1, 3))
        normal.append((w @ water.normals[water.normal_triangles[group]]).reshape(-1, 3))
        flux.append(np.repeat(lit[group] / count**2, count**2))
    return np.concatenate(position), np.concatenate(normal), np.concatenate(flux)


def refract(d, n, eta):
    """Refracted unit directions (k,3) of light along d (3,) at normals n (k,3), any length, and the transmittance (k,):
    Snell's law in the plane of incidence, Fresnel's in the angles' sines and tangents; none where d meets the back."""
    length = np.linalg.norm(n, axis=1, keepdims=True)
    n = n / np.maximum(length, 1e-300)
    cos_i = np.clip(-(n @ d), 0, 1)
    across = d + cos_i[:, None] * n  # the part of d along the surface, of length sin i
    sin_t = np.linalg.norm(across, axis=1) / eta
    t = across / eta - np.sqrt(1 - sin_t**2)[:, None] * n
    i, r = np.arccos(cos_i), np.arcsin(sin_t)
    small = i < 1e-6
    i, r = np.where(small, 1.0, i), np.where(small, 0.5, r)
    lost = (np.sin(i - r) ** 2 / np.sin(i + r) ** 2 + np.tan(i - r) ** 2 / np.tan(i + r) ** 2) / 2
    lost = np.where(small, ((eta - 1) / (eta + 1)) ** 2, lost)
    return t, np.where(cos_i > 0, 1 - lost, 0.0)


def _nearest(origin, direction, solids):
    """Distance (k,), solid, triangle and barycentrics (k,3) of the first hit of rays with triangles, by testing all."""
    best, owner = np.full(len(origin), np.inf), np.full(len(origin), -1)
    triangle, bary = np.zeros(len(origin), int), np.zeros((len(origin), 3))
    for k, solid in enumerate(solids):
        for number, (a, b, c) in enumerate(solid):
            e1, e2 = b - a, c - a
            p = np.cross(direction, e2)
            det = p @ e1
            with np.errstate(divide="ignore", invalid="ignore"):
                s = origin - a
                u = (s * p).sum(-1) / det
                q = np.cross(s, e1)
                v = (q * direction).sum(-1) / det
                far = q @ e2 / det
                hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (far > _EPS) & (far < best)
            best[hit], owner[hit], triangle[hit] = far[hit], k, number
            bary[hit] = np.stack([1 - u - v, u, v], -1)[hit]
    return best, owner, triangle, bary


def _texel_area(receiver, resolution):
    """Area (T,) [m^2] of a texel on each triangle of a receiver."""
    v, uv = receiver.positions[receiver.triangles], receiver.uvs * resolution
    world = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1)
    e1, e2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return world / np.abs(e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0])
