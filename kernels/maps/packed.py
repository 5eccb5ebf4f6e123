"""Maps of different sizes in sheets of one size, for methods that know one resolution.

The largest receivers keep an image each. Smaller ones are laid side by side into images of that size, each with the
texels that it has by itself, bit for bit; to a method they are one receiver in several charts. What it answers is cut
apart again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..scene import Receiver, Solution
from .shelves import shelved
from .texels import Texels


class Packed:
    """Receivers of a Scene with Texels of different resolutions as `scene` and `texels` of one."""

    def __init__(self, scene, texels):
        self._receivers, self._texels = scene.receivers, texels
        self._side = max(own.resolution for own in texels)
        self._places = shelved([own.resolution for own in texels], self._side)
        sheets = [
            [
                (scene.receivers[k], texels[k], *self._places[k][1:])
                for k in range(len(texels))
                if self._places[k][0] == n
            ]
            for n in range(max(sheet for sheet, _, _ in self._places) + 1)
        ]
        self.scene = replace(scene, receivers=tuple(_receiver(parts, self._side) for parts in sheets))
        self.texels = tuple(_texels(parts, self._side) for parts in sheets)

    def unpack(self, solution) -> Solution:
        """The Solution for the receivers themselves, of that for `scene` and `texels`."""
        images = tuple(self._cut(solution.images, k) for k in range(len(self._texels)))
        status = tuple(self._cut(solution.status, k) for k in range(len(self._texels)))
        work = solution.diagnostics
        work.flux_received = {
            receiver.name: own.area @ image.reshape(-1, 3)[own.texel] / work.map_scale
            for receiver, own, image in zip(self._receivers, self._texels, images, strict=True)
        }
        return Solution(images, status, work)

    def _cut(self, sheets, k):
        sheet, row, column = self._places[k]
        side = self._texels[k].resolution
        return sheets[sheet][row : row + side, column : column + side].copy()


def packed(scene, texels):
    """The Packed of a Scene whose Texels differ in resolution; None where they do not."""
    mixed = len(texels) == len(scene.receivers) and len({own.resolution for own in texels}) > 1
    return Packed(scene, texels) if mixed else None


def _receiver(parts, side):
    """The Receivers of parts (Receiver, Texels, row, column) of a sheet as one."""
    if len(parts) == 1 and parts[0][1].resolution == side:
        return parts[0][0]
    base = np.cumsum([0, *(len(receiver.positions) for receiver, *_ in parts)])
    triangles = [receiver.triangles + start for (receiver, *_), start in zip(parts, base, strict=False)]
    uvs = [(np.clip(r.uvs, 0, 1) * own.resolution + (column, row)) / side for r, own, row, column in parts]
    positions = np.concatenate([receiver.positions for receiver, *_ in parts])
    return Receiver(_name(parts), positions, np.concatenate(triangles), np.concatenate(uvs))


def _name(parts):
    more = f" and {len(parts) - 1} more" if len(parts) > 1 else ""
    return parts[0][0].name + more


def _texels(parts, side):
    """The Texels of parts of a sheet as of one receiver."""
    if len(parts) == 1 and parts[0][1].resolution == side:
        return parts[0][1]
    owns = [own for _, own, _, _ in parts]
    home, whole = np.full(side**2, -1, np.int64), np.zeros(side**2, bool)
    counts = np.cumsum([0, *(len(own.texel) for own in owns)])
    faces = np.cumsum([0, *(len(own.chart) for own in owns)])
    charts = np.cumsum([0, *(own.chart.max(initial=-1) + 1 for own in owns)])
    moved = [
        lambda flat, own=own, row=row, column=column: _moved(flat, own.resolution, row, column, side)
        for _, own, row, column in parts
    ]
    for (_, own, row, column), move, count in zip(parts, moved, counts, strict=False):
        whole[move(np.arange(own.resolution**2))] = own.whole
        _settle(home.reshape(side, side), np.where(own.home < 0, -1, own.home + count), row, column)
    return Texels(
        resolution=side,
        texel=np.concatenate([move(own.texel) for own, move in zip(owns, moved, strict=True)]),
        positions=np.concatenate([own.positions for own in owns]),
        normals=np.concatenate([own.normals for own in owns]),
        triangle=np.concatenate([own.triangle + start for own, start in zip(owns, faces, strict=False)]),
        chart=np.concatenate([own.chart + start for own, start in zip(owns, charts, strict=False)]),
        area=np.concatenate([own.area for own in owns]),
        home=home,
        whole=whole,
        pad_texel=np.concatenate([move(own.pad_texel) for own, move in zip(owns, moved, strict=True)]),
        pad_source=np.concatenate([own.pad_source + start for own, start in zip(owns, counts, strict=False)]),
    )


def _settle(homes, home, row, column):
    """Put an image's `home` in its place among `homes`, and round it the ring past its border, as rounding asks for."""
    side = int(np.sqrt(len(home)))
    ring = np.pad(home.reshape(side, side), 1, mode="edge")
    up, left = min(row, 1), min(column, 1)
    place = homes[row - up : row + side + 1, column - left : column + side + 1]
    place[:] = ring[1 - up :, 1 - left :][: place.shape[0], : place.shape[1]]


def _moved(flat, own, row, column, side):
    """Flat indices of an image of `own` texels a side where it lies in one of `side`."""
    down, right = np.divmod(flat, own)
    return (down + row) * side + right + column
