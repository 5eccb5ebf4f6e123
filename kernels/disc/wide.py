"""Blur by ellipses of many texels, by Fourier transforms, one chart at a time.

A texel takes the mean of what its ellipse covers of the chart, so that even light stays even; what is then too much or
too little, next to its borders, is made up for there. To throw light back, as for small ellipses, is worse where an
ellipse is as large as its chart.
"""

from __future__ import annotations

import numpy as np

from .kernels import kernel, representatives

_ROUNDING = 1e-13  # of all flux
_LEAST = 1e-3  # of an ellipse, on its chart


def blur_wide(flux, on, home, moments):
    """Flux (rows,columns) blurred over the texels that are `on` (rows,columns) a chart; what is not on it stays.

    moments (3,K): xx, yy, xy [texel^2] of the ellipses; home (rows,columns) which of these K each texel has.
    """
    moments = moments[:, home[on]]
    inside = np.where(on, flux, 0.0)
    kernels, parts, evens = [], [], []
    for own, weight in representatives(moments):
        kernels.append(_within(kernel(own), max(flux.shape)))
        part, even = np.zeros((2, *flux.shape))
        part[on], even[on] = inside[on] * weight, weight
        parts.append(part)
        evens.append(even)
    blurred, stays = _convolved(parts, kernels)[on], np.maximum(_convolved(evens, kernels)[on], _LEAST)
    blurred[blurred < _ROUNDING * inside.sum()] = 0  # what the transform leaves where no light is
    out = flux.copy()
    out[on] = _whole(blurred / stays, np.maximum(1 - stays, 0), inside.sum())
    return out


def _whole(flux, beside, total):
    """Flux (n,) of `total`, by more or less of what has light from beside the chart in it, as a share (n,)."""
    margin = flux * beside
    if not margin.sum() > 0:
        return flux
    more = (total - flux.sum()) / margin.sum()
    return flux + more * margin if more >= -1 else flux * (total / flux.sum())


def _within(shares, side):
    """The part of a kernel that joins two cells of an image with sides of up to `side` cells: the rest leaves it."""
    over = max(0, len(shares) // 2 - (side - 1))
    return shares[over : len(shares) - over, over : len(shares) - over].copy() if over else shares


def _convolved(images, kernels):
    """The sum of images, each convolved with its kernel, dark outside."""
    reach = max(len(one) for one in kernels) // 2
    rows, columns = images[0].shape
    shape = [_smooth(n + 2 * reach) for n in (rows, columns)]
    total = 0.0
    for image, one in zip(images, kernels, strict=True):
        middle = len(one) // 2
        centred = np.zeros(shape)
        centred[: len(one), : len(one)] = one
        factor = np.fft.rfft2(np.roll(centred, (-middle, -middle), axis=(0, 1)))
        total = total + np.fft.rfft2(image, shape) * factor
    return np.fft.irfft2(total, shape)[:rows, :columns]


def _smooth(n):
    """The least number from n on without prime factors above 5, where the transform is quick."""
    while True:
        rest = n
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return n
        n += 1
