"""Blur by ellipses of a few texels: every cell gives the texels round its own what its kernel says.

All cells that lie alike in their texels share the kernel's taps on texels, so a block of texels is a product of two
matrices, taps by cells and cells by texels. What would leave its chart is thrown back by the border, as by a mirror, or
stays where it is; so no light is lost, and along straight borders even light stays even.
"""

from __future__ import annotations

import numpy as np

from .kernels import kernel, representatives

_BLOCK = 1 << 13  # texels at once: what is known of them stays in the cache


def blur_near(cells, chart, home, moments, grain):
    """Flux (C,rows,columns) of texels, of flux (C, grain rows, grain columns) of their cells, blurred on charts.

    chart (rows,columns) of each texel, -1 where nothing moves; moments (3,K): xx, yy, xy [texel^2] of the ellipses;
    home (rows,columns) which of these K each texel has.
    """
    kinds = _kinds(home, moments, grain)
    reach = max((_reach(taps) for taps, _ in kinds), default=0)
    inner = _inner(chart, reach)
    rows, columns = chart.shape
    out = np.zeros((len(cells), rows + 2 * reach, columns + 2 * reach))
    step = max(_BLOCK // columns, 1)
    for start in range(0, rows, step):
        part = slice(start, min(start + step, rows))
        alike = _alike(cells[:, part.start * grain : part.stop * grain], grain)
        still = chart[part] < 0
        if still.any():
            kept = alike.sum(1).reshape(-1, *still.shape) * still
            out[:, part.start + reach : part.stop + reach, reach : reach + columns] += kept
        for taps, weight in kinds:
            share = (weight[part] * inner[part]).ravel()
            if share.any():
                _give(out, taps, alike * share, part, reach)
    out = out[:, reach : reach + rows, reach : reach + columns]
    return out + _at_borders(cells, chart, inner, kinds, grain)


def _kinds(home, moments, grain):
    """The taps (S, grain^2) of each kernel that is used, and its weight (rows,columns) on each texel, 1 for all."""
    kinds = []
    for own, weight in representatives(moments):
        image = np.append(weight, 0.0)[home] if np.ndim(weight) else np.broadcast_to(weight, home.shape)
        kinds.append((_taps(kernel(own * grain**2), grain), image))
    return kinds


def _taps(shares, grain):
    """Shares (S, grain^2) that the texels round one, (2r+1)^2 = S, get of each of its cells by a kernel on cells."""
    reach = len(shares) // 2
    texels = -(-reach // grain)
    width = 2 * texels + 1
    taps = np.zeros((width, width, grain, grain))
    for i in range(grain):
        for j in range(grain):
            wide = np.zeros((grain * width, grain * width))
            row, column = texels * grain + i - reach, texels * grain + j - reach
            wide[row : row + len(shares), column : column + len(shares)] = shares
            taps[:, :, i, j] = wide.reshape(width, grain, width, grain).sum((1, 3))
    return taps.reshape(width * width, grain * grain)


def _reach(taps):
    """Texels r that taps ((2r+1)^2, cells) reach."""
    return (round(np.sqrt(len(taps))) - 1) // 2


def _shifts(reach):
    """Rows and columns (S,) that taps of that reach move by."""
    row, column = np.divmod(np.arange((2 * reach + 1) ** 2), 2 * reach + 1)
    return row - reach, column - reach


def _alike(cells, grain):
    """Cells (C, grain rows, grain columns) as (C, grain^2, rows columns), by their places in their texels."""
    channels, height, width = cells.shape
    rows, columns = height // grain, width // grain
    return cells.reshape(channels, rows, grain, columns, grain).transpose(0, 2, 4, 1, 3).reshape(
        channels, grain * grain, rows * columns
    )  # fmt: skip


def _give(out, taps, alike, part, margin):
    """Add to out (C,rows,columns), with a margin round it, what cells `alike` of the rows `part` give by taps."""
    given = (taps @ alike).reshape(len(out), len(taps), part.stop - part.start, -1)
    columns = given.shape[3]
    for k, (down, right) in enumerate(zip(*_shifts(_reach(taps)), strict=True)):
        top, left = part.start + margin + down, margin + right
        out[:, top : top + given.shape[2], left : left + columns] += given[:, k]


def _inner(chart, reach):
    """Whether (rows,columns) all texels that are `reach` or less off, both ways, are on the same chart."""
    inner = chart >= 0
    for axis in (0, 1):
        before, along = inner.copy(), np.moveaxis(inner, axis, 0)
        known, number = np.moveaxis(before, axis, 0), np.moveaxis(chart, axis, 0)
        for k in range(1, min(reach, len(number)) + 1):
            same = number[k:] == number[:-k]
            along[:-k] &= known[k:] & same
            along[k:] &= known[:-k] & same
            along[:k] = along[-k:] = False
    return inner


def _at_borders(cells, chart, inner, kinds, grain):
    """What the cells of texels that are not `inner` give (C,rows,columns)."""
    channels, (rows, columns) = len(cells), chart.shape
    row, column = np.nonzero((chart >= 0) & ~inner)
    place = np.arange(grain)
    own = cells[:, row * grain + place[:, None, None], column * grain + place[:, None]]
    own = own.reshape(channels, grain * grain, -1)
    out = np.zeros((channels, rows * columns))
    for reach in {_reach(taps) for taps, _ in kinds}:
        target = _thrown_back(chart, row, column, reach)
        for taps, weight in kinds:
            if _reach(taps) == reach:
                share = weight[row, column]
                at = np.flatnonzero(share)
                to = target[:, at].ravel()
                for channel in range(channels):
                    given = taps @ (own[channel][:, at] * share[at])
                    out[channel] += np.bincount(to, given.ravel(), minlength=rows * columns)
    return out.reshape(channels, rows, columns)


def _thrown_back(chart, row, column, reach):
    """Flat index (S,n) of the texels that texels (n,) reach by all shifts, thrown back by the border of their chart
    along rows and along columns; their own where that, too, is off it."""
    number, columns = chart[row, column], chart.shape[1]
    steps = np.arange(-reach, reach + 1)[:, None]
    padded = np.pad(chart, reach, constant_values=-1)

    def run(down, right):
        """How many texels (n,) of the chart follow along a direction, up to `reach`."""
        count, going = np.zeros(len(row), np.int64), np.ones(len(row), bool)
        for k in range(1, reach + 1):
            going &= padded[row + reach + k * down, column + reach + k * right] == number
            count += going
        return count

    to_row = row + _mirrored(steps, run(-1, 0), run(1, 0))
    to_column = column + _mirrored(steps, run(0, -1), run(0, 1))
    target = (to_row[:, None] * columns + to_column).reshape(len(steps) ** 2, len(row))
    return np.where(np.take(chart, target) == number, target, row * columns + column)


def _mirrored(step, before, after):
    """Steps (s,n) of step (s,1) where `before` (n,) are free one way and `after` (n,) the other."""
    step = np.where(step > after, 2 * after + 1 - step, step)
    step = np.where(step < -before, -2 * before - 1 - step, step)
    return np.clip(step, -before, after)
