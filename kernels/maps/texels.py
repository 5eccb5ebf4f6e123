"""Texels of a lightmap: where each lies on its receiver, how much of the world it stands for, which one owns what.

A texel whose centre lies in a UV triangle is owned. One that a chart only touches joins an owned neighbour on the same
surface, flux and area together, so that no light is lost and no sliver divides by nearly nothing. Padding copies border
texels outwards, so that a bilinear look-up at a chart's border never sees black.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .charts import charts
from .coverage import edge_coverage
from .uv_raster import barycentrics, cross2, owners

_TOUCHED = 1e-7  # in texels: the rounding of coverage sums
_FLAT = 1e-12  # texels^2
_OVERLAP = 1e-3  # in texels: UV layers are float32
_RING = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1))


class UVError(ValueError):
    """The UV layer cannot carry a lightmap; the message says why and what to do."""


def gather_all(texels, flux):
    """What Texels of all images own (C,K) of flux (C, images * resolution^2), and how much (C,) lies off the charts."""
    parts = [
        [own.gather(part) for own, part in zip(texels, np.split(channel, len(texels)), strict=True)] for channel in flux
    ]
    owned = np.stack([np.concatenate([own for own, _ in channel]) for channel in parts])
    return owned, np.array([sum(off for _, off in channel) for channel in parts])


@dataclass(frozen=True)
class Texels:
    """The K texels that a receiver owns in an image of resolution^2; a flat index is row * resolution + column.

    texel (K,) flat index; positions (K,3) [m] and unit normals (K,3) of the receiver there; triangle (K,) of the
    receiver; chart (T,) that each of the receiver's triangles is in; area (K,) [m^2] that the texel stands for; home
    (resolution^2,) flat index -> 0..K-1, -1 off the charts, set for one ring of texels round them too, since landing
    points on a border round either way; whole (resolution^2,) bool, the receiver covers all of it; pad_texel (Q,) flat
    index, pad_source (Q,) in 0..K-1, of texels that joined another and of padding.
    """

    resolution: int
    texel: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    triangle: np.ndarray
    chart: np.ndarray
    area: np.ndarray
    home: np.ndarray
    whole: np.ndarray
    pad_texel: np.ndarray
    pad_source: np.ndarray

    def gather(self, flux):
        """What the texels own (K,) of flux (resolution^2,) over the image, and how much lies off the charts."""
        on_chart = self.home >= 0
        owned = np.bincount(self.home[on_chart], flux[on_chart], minlength=len(self.texel))
        return owned, float(flux[~on_chart].sum())

    def image(self, values):
        """Values (K, ...) as a padded image (resolution, resolution, ...), zero where no chart is."""
        if len(self.texel) == self.resolution**2:  # in order, and nothing to pad
            return values.reshape(self.resolution, self.resolution, *values.shape[1:])
        flat = np.zeros((self.resolution**2, *values.shape[1:]), values.dtype)
        flat[self.texel] = values
        flat[self.pad_texel] = values[self.pad_source]
        return flat.reshape(self.resolution, self.resolution, *values.shape[1:])


def rasterise(receiver, resolution, padding=4):
    """The Texels of a Receiver, `resolution` a side, charts grown by `padding` texels.

    Raises UVError for UVs that are not finite, outside 0..1, without area or overlapping, ValueError for positions that
    are not finite and for sizes that are none.
    """
    if not resolution >= 1 or not padding >= 0:
        raise ValueError(f"resolution must be 1 or more and padding 0 or more, got {resolution} and {padding}")
    if not np.isfinite(receiver.positions).all():
        raise ValueError(f"positions of receiver '{receiver.name}' must be finite")
    corners = _texel_corners(receiver, resolution)
    normals, world = _triangle_normals(receiver)
    flat = cross2(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    usable = (np.abs(flat) > _FLAT) & (world > 0)
    if not usable.any():
        raise UVError("its UV map has no area; unwrap it, or press Make Lightmap UVs")
    covered, area = _areas(corners, flat, world, usable, resolution)
    if covered.max() > 1 + _OVERLAP:
        count = np.count_nonzero(covered > 1 + _OVERLAP)
        share = count / np.count_nonzero(covered > _TOUCHED)
        raise UVError(
            f"{share:.2%} of its UV map overlaps ({count} texels); unwrap it without overlaps, or press Make Lightmap "
            "UVs; apply modifiers that copy faces first"
        )
    owner, centred = owners(corners, usable, resolution)
    touched = (owner >= 0) & (covered > _TOUCHED)
    positions = _positions(receiver, corners, owner, touched, resolution)
    footprint = np.sqrt(np.where(usable, world / np.maximum(np.abs(flat), 1e-300), 0))
    host = _hosts(touched, touched & centred, positions, 4 * footprint[owner], resolution)
    texel = np.flatnonzero(host == np.arange(len(host)))
    home = np.full(resolution**2, -1, np.int64)
    home[texel] = np.arange(len(texel))
    home[touched] = home[host[touched]]
    area = np.bincount(home[touched], area[touched], minlength=len(texel))
    joined = np.flatnonzero(touched & (host != np.arange(len(host))))
    rings = _rings(home, resolution, max(padding, 1))
    pads = [(joined, home[joined]), *rings[:padding]]
    home[rings[0][0]] = rings[0][1]
    return Texels(
        resolution=resolution,
        texel=texel,
        positions=positions[texel],
        normals=normals[owner[texel]],
        triangle=owner[texel],
        chart=charts(receiver.triangles, receiver.uvs),
        area=area,
        home=home,
        whole=covered > 1 - 1e-6,
        pad_texel=np.concatenate([pad[0] for pad in pads]),
        pad_source=np.concatenate([pad[1] for pad in pads]),
    )


def overlap(uvs, resolution):
    """Which share of the texels that UV triangles uvs (T,3,2) cover lies in more than one of them."""
    corners = np.asarray(uvs, float) * resolution
    flat = cross2(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    covered, _ = _areas(corners, flat, np.abs(flat), np.abs(flat) > _FLAT, resolution)
    return np.count_nonzero(covered > 1 + _OVERLAP) / max(np.count_nonzero(covered > _TOUCHED), 1)


def _texel_corners(receiver, resolution):
    """UV corners (T,3,2) in texel units; raises UVError where they are not finite or leave the unit square."""
    uvs = np.asarray(receiver.uvs, float)
    if not np.isfinite(uvs).all():
        raise UVError("its UV map holds values that are not numbers; unwrap it again")
    if len(uvs) and (uvs.min() < -1e-5 or uvs.max() > 1 + 1e-5):
        raise UVError(
            f"its UV map leaves the unit square (it spans {uvs.min():.3g} to {uvs.max():.3g}); "
            "scale it into 0..1 (UV > Pack Islands), or into whole UDIM tiles"
        )
    return np.clip(uvs, 0, 1) * resolution


def _triangle_normals(receiver):
    """Unit normals (T,3) and areas (T,) [m^2] of a receiver's triangles; zero normals where there is no area."""
    v = receiver.positions[receiver.triangles]
    normal = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return normal / np.maximum(length, np.finfo(float).tiny)[:, None], length / 2


def _areas(corners, flat, world, usable, resolution):
    """Share of each texel that charts cover, and world area [m^2] in each: (resolution^2,) both."""
    turn = np.sign(flat[usable])
    start = corners[usable].reshape(-1, 2).T
    end = corners[usable][:, [1, 2, 0]].reshape(-1, 2).T
    density = world[usable] / np.abs(flat[usable])
    shape = (resolution, resolution)
    weights = np.repeat(np.stack([turn, turn * density]), 3, axis=1)
    covered, area = edge_coverage(start, end, weights, shape)
    return covered.ravel(), area.ravel()


def _positions(receiver, corners, owner, touched, resolution):
    """World positions (resolution^2,3) at the texels' centres, or at the chart's nearest point to them."""
    flat = np.flatnonzero(touched)
    row, column = np.divmod(flat, resolution)
    bary, _ = barycentrics(np.column_stack([column, row]) + 0.5, corners[owner[flat]])
    positions = np.zeros((resolution**2, 3))
    vertices = receiver.positions[receiver.triangles[owner[flat]]]
    positions[flat] = (bary[:, :, None] * vertices).sum(1)
    return positions


def _neighbours(flat, resolution):
    """Flat indices (8,n) of the texels round each, -1 outside the image; those across an edge come first."""
    row, column = np.divmod(flat, resolution)
    step = np.array(_RING)
    r, c = row + step[:, :1], column + step[:, 1:]
    inside = (r >= 0) & (r < resolution) & (c >= 0) & (c < resolution)
    return np.where(inside, r * resolution + c, -1)


def _hosts(touched, centred, positions, reach, resolution):
    """Texel that each touched texel gives its light to: itself where it is centred or has no neighbour that is, within
    `reach` [m] on the surface. -1 off the charts."""
    host = np.where(touched, np.arange(len(touched)), -1)
    rim = np.flatnonzero(touched & ~centred)
    around = _neighbours(rim, resolution)
    distance = np.linalg.norm(positions[around] - positions[rim], axis=2)
    distance[(around < 0) | ~centred[around]] = np.inf
    best = distance.argmin(0)
    pick = np.arange(len(rim))
    close = distance[best, pick] < reach[rim]
    host[rim[close]] = around[best, pick][close]
    return host


def _rings(home, resolution, count):
    """`count` rings of texels round the charts: pairs of flat indices and the k in 0..K-1 that each copies."""
    source = home.copy()
    rings = []
    for _ in range(count):
        empty = np.flatnonzero(source < 0)
        around = _neighbours(empty, resolution)
        from_there = np.where(around >= 0, source[around], -1)
        first = (from_there >= 0).argmax(0)
        value = from_there[first, np.arange(len(empty))]
        grown = value >= 0
        source[empty[grown]] = value[grown]
        rings.append((empty[grown], value[grown]))
    return rings
