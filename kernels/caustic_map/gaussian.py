"""Splats of the shape of a Gaussian, on the charts of a lightmap: every chart's light stays its own.

A splat near a border is weighted so that energy is kept and even light stays even: by mirrors on a rectangle, else by
scaling the kernel K symmetrically, s_i K_ij s_j, until its rows weigh one (Sinkhorn & Knopp 1967).
"""

from __future__ import annotations

import numpy as np

_REACH = 3.5  # deviations
_LEAST = 0.2  # texels: narrower ones change nothing
_SCALINGS = 12


def splat(light, texels, widths):
    """Irradiance (C,K) of Texels, of `light` (C,K), spread by Gaussians; widths: of each chart, its deviation
    [texel]."""
    chart = texels.chart[texels.triangle]
    side = texels.resolution
    row, column = np.divmod(texels.texel, side)
    light = light.copy()
    for number in np.flatnonzero(np.asarray(widths) > _LEAST):
        own = np.flatnonzero(chart == number)
        if not len(own):
            continue
        r, c = row[own] - row[own].min(), column[own] - column[own].min()
        shape = r.max() + 1, c.max() + 1
        kernel = _kernel(widths[number], max(shape))
        area = np.zeros(shape)
        area[r, c] = texels.area[own]
        for channel in light:
            image = np.zeros(shape)
            image[r, c] = channel[own] * texels.area[own]
            channel[own] = _spread(image, area, kernel)[r, c]
    return light


def _kernel(width, longest):
    reach = int(np.ceil(min(_REACH * width, longest)))
    taps = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    return taps / taps.sum()


def _spread(flux, area, kernel):
    """Irradiance (H,W) of flux (H,W) on texels of area (H,W), 0 off the chart."""
    if area.min() > 0 and np.ptp(area) < 1e-6 * area.max():
        return _convolved(flux, kernel, "symmetric") / area
    scale = np.where(area > 0, 1 / np.sqrt(area.max()), 0.0)
    for _ in range(_SCALINGS):
        rows = _convolved(area * scale, kernel, "constant")
        scale = np.sqrt(scale / np.where(rows > 0, rows, np.inf))
    return scale * _convolved(scale * flux, kernel, "constant")


def _convolved(image, kernel, border):
    reach = len(kernel) // 2
    for _ in range(2):
        padded = np.pad(image, ((reach, reach), (0, 0)), border)
        image = sum(k * padded[i : i + image.shape[0]] for i, k in enumerate(kernel)).T
    return image
