"""Blur by ellipses of many texels, by Fourier transforms, one chart at a time.

Light that would leave its chart stays where such light comes from, which keeps the energy and leaves even light nearly
even. To throw it back, as for small ellipses, is worse where an ellipse is as large as its chart.
"""

from __future__ import annotations

import numpy as np

from .kernels import kernel, representatives

_ROUNDING = 1e-13  # of all flux


def blur_wide(flux, on, home, moments):
    """Flux (rows,columns) blurred over the texels that are `on` (rows,columns) a chart; what is not on it stays.

    moments (3,K): xx, yy, xy [texel^2] of the ellipses; home (rows,columns) which of these K each texel has.
    """
    moments = moments[:, home[on]]
    inside = np.where(on, flux, 0.0)
    kernels, sizes, parts = [], [], []
    for own, weight in representatives(moments):
        kernels.append(kernel(own))
        sizes.append(len(kernels[-1]))
        kernels[-1] = _within(kernels[-1], max(flux.shape))
        part = np.zeros(flux.shape)
        part[on] = inside[on] * weight
        parts.append(part)
    largest = kernels[int(np.argmax(sizes))]
    blurred = on * _convolved(parts, kernels)
    blurred[blurred < _ROUNDING * inside.sum()] = 0  # what the transform leaves where no light is
    return np.where(on, blurred + _kept(inside, on, moments, largest, inside.sum() - blurred.sum()), flux)


def _within(shares, side):
    """The part of a kernel that joins two cells of an image with sides of up to `side` cells: the rest leaves it."""
    over = max(0, len(shares) // 2 - (side - 1))
    return shares[over : len(shares) - over, over : len(shares) - over].copy() if over else shares


def _kept(inside, on, moments, largest, gone):
    """Flux of which `gone` left the chart, where such light comes from: as the kernel of the largest ellipse tells, and
    each one's own."""
    leaves = inside * np.clip(1 - _convolved([on.astype(float)], [largest]), 0, 1)
    leaves[on] *= np.sqrt(moments[0] + moments[1])
    return leaves * (gone / leaves.sum()) if leaves.sum() > 0 else 0.0


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
