"""What spreading a beam evenly over its image will leave as error, told from how far the image is from affine."""

from __future__ import annotations

import numpy as np

_ERROR = 2.0  # of the predicted error: measured on pools of many waves and meshes, 0.3 to 1.5 times that
# texels, and of an image's length: an image that is bent by more than both is no beam's, but torn - by a seam of its
# chart, or by an edge of the receiver that hides a part of the same chart
_TORN, _SHARP = 4.0, 0.15


def predict(bent, x, y, flux, light, side):
    """Sum of squared errors (n,) on the texels, of flux over a texel's area squared; inf for images that are torn.

    Images x, y (3,n) [texel] on a map of side^2 texels are `bent` (n,) [texel]; flux (n,) over a texel's area; light:
    mean and range (n,) of the part of it that passes, or numbers.

    A beam of flux F that is L texels long and w wide puts some F bent / L into the wrong texel on each of L texels, and
    less by w^-3 where it is wide and what moves stays inside. Where the light ranges over R, linearly, its variance is
    R^2 / 18.
    """
    mean, spans = light
    (x1, x2), (y1, y2) = x[1:] - x[0], y[1:] - y[0]
    long = np.maximum(np.maximum(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2), (x2 - x1) ** 2 + (y2 - y1) ** 2)
    long = np.sqrt(np.maximum(long, 1.0))
    wide = np.maximum(np.abs(x1 * y2 - x2 * y1) / long, 1.0)
    error = _ERROR * (flux * mean * np.minimum(bent, wide)) ** 2 / (long * wide**3)
    if np.ndim(spans):
        error += (flux * spans) ** 2 / (9 * long * wide)
    beside = [(v.max(0) < -bent) | (v.min(0) > side + bent) for v in (x, y)]
    error[bent > np.maximum(_TORN, _SHARP * long)] = np.inf
    error[beside[0] | beside[1]] = 0  # what lands beyond the map is wrong on no texel
    return error


def bend(v):
    """Largest distance (n,) of the middles v[3:] of edges from the middles of the corners v[:3]."""
    off = [np.abs(v[3 + k] - (v[k] + v[(k + 1) % 3]) / 2) for k in range(3)]
    return np.maximum(np.maximum(off[0], off[1]), off[2])


def cut_off(error, most, weight=None):
    """The largest of errors (n,) over their weights (n,) up to which the sum of errors is no more than `most`; -1 where
    even the least is more."""
    if error.sum() <= most:
        return np.inf
    if weight is None:
        rising = over = np.sort(error)
    else:
        order = np.argsort(error / weight)
        rising, over = error[order], (error / weight)[order]
    count = np.searchsorted(np.cumsum(rising), most, side="right")
    return over[count - 1] if count else -1.0
