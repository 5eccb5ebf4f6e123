"""References of a mesh: its triangles as they are, with normals interpolated between their corners.

Every triangle is cut into parts^2, and the flux of each part is spread evenly over the triangle between the images of
its corners. Its share in a texel is that of the area below and left of the texel's corners, by clipping.
"""

from __future__ import annotations

import numpy as np

from .reference_light import refract

_BLOCK = 1 << 14  # parts at a time
_POLYGONS = 1 << 13  # clipped polygons at a time
_SLIVER = 1e-10  # texel^2: smaller images are left at their middles


def by_mesh(corners, normals, direction, eta, floor, resolution, parts):
    """Irradiance (H,W) for 1 W/m^2 under triangles with corners (T,3,3) and normals (T,3,3) at them."""
    image = np.zeros((resolution + 2, resolution + 2))
    points, cells = _lattice(parts)
    values = np.concatenate([corners, normals], 2).transpose(2, 0, 1)
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ -direction / 2
    step = max(1, _BLOCK // len(cells))
    for start in range(0, len(corners), step):
        block = values[:, start : start + step] @ points.T
        go_x, go_y, passed = refract(direction, block[3:], eta)
        landed = floor.land(*block[:3], go_x, go_y)
        x, y = (v[:, cells].reshape(-1, 3) / floor.side * resolution + resolution / 2 for v in landed)
        share = np.maximum(area[start : start + step, None], 0) / len(cells)
        _deposit(image, x, y, (share * passed[:, cells].mean(2)).ravel())
    return image[1:-1, 1:-1] / floor.texel_area(resolution)


def _lattice(parts):
    """Barycentric coordinates (n,3) of the lattice's points, and the cells (parts^2,3) between them."""
    i, j = (v.ravel() for v in np.mgrid[: parts + 1, : parts + 1])
    kept = i + j <= parts
    number = np.cumsum(kept).reshape(parts + 1, parts + 1) - 1
    a, b = i[i + j < parts], j[i + j < parts]
    up = np.stack([number[a, b], number[a + 1, b], number[a, b + 1]], 1)
    a, b = i[i + j < parts - 1], j[i + j < parts - 1]
    down = np.stack([number[a + 1, b], number[a + 1, b + 1], number[a, b + 1]], 1)
    points = np.stack([parts - i - j, i, j], 1)[kept] / parts
    return points, np.concatenate([up, down])


def _deposit(image, x, y, flux):
    """Leave flux (n,) evenly on triangles x, y (n,3) in texels; the image has one texel round it for all beyond."""
    side = len(image)
    sliver = np.abs(_area(x, y)) < _SLIVER
    thin_x, thin_y = (np.clip(v[sliver].mean(1).astype(int) + 1, 0, side - 1) for v in (x, y))
    image += np.bincount(thin_y * side + thin_x, flux[sliver], side * side).reshape(side, side)
    x, y, flux = x[~sliver] + 1, y[~sliver] + 1, flux[~sliver]
    left, low, right, top = (np.clip(v, 0, side - 1).astype(int) for v in (x.min(1), y.min(1), x.max(1), y.max(1)))
    wide, high = right - left + 1, top - low + 1
    size = wide * side + high
    order = np.argsort(size, kind="stable")
    for group in filter(len, np.split(order, np.flatnonzero(np.diff(size[order])) + 1)):
        step = max(1, _POLYGONS // (wide[group[0]] * high[group[0]]))
        for take in np.split(group, range(step, len(group), step)):
            window = _shares(x[take] - left[take, None], y[take] - low[take, None], wide[take[0]], high[take[0]])
            row, column = np.ogrid[: window.shape[1], : window.shape[2]]
            cell = (low[take, None, None] + row) * side + left[take, None, None] + column
            first = cell.min()
            share = np.bincount((cell - first).ravel(), (window * flux[take, None, None]).ravel())
            image.reshape(-1)[first : first + len(share)] += share


def _shares(x, y, wide, high):
    """Part (n, high, wide) of triangles x, y (n,3) that lies in each cell of a grid that holds them."""
    whole = _area(x, y)
    below = np.empty((len(x), high, wide))
    for j in range(high):
        under = _clip(y, x, j + 1) if j + 1 < high else (y, x)
        for i in range(wide):
            corner = _clip(under[1], under[0], i + 1) if i + 1 < wide else (under[1], under[0])
            below[:, j, i] = _area(*corner) / whole
    return np.diff(np.diff(below, axis=1, prepend=0), axis=2, prepend=0)


def _clip(u, v, limit):
    """Polygons (n,m) with coordinates u, v, cut at u = limit: crossings are inserted, what is beyond falls onto it."""
    next_u, next_v = np.roll(u, -1, 1), np.roll(v, -1, 1)
    run = next_u - u
    at = np.clip((limit - u) / np.where(run == 0, 1, run), 0, 1)
    cut_u = np.stack([u, u + at * run], 2).reshape(len(u), -1)
    cut_v = np.stack([v, v + at * (next_v - v)], 2).reshape(len(u), -1)
    return np.minimum(cut_u, limit), cut_v


def _area(x, y):
    """Signed area (n,) of polygons (n,m)."""
    return (x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y).sum(1) / 2
