"""The lamp's disc: light that comes from a disc, not from a point, is spread over an ellipse on the receiver.

The map is that of the disc's centre, convolved with each texel's ellipse (`moments.py`). What is convolved are the
fluxes of cells of a grid, finer than the texels where the ellipse is small. Of ellipses that change over a receiver a
few are blended (`kernels.py`); they are small and then summed cell by cell (`near.py`), or many texels wide and
convolved by transforms (`wide.py`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..optics import sun_frame
from ..scene import Piece, Sun
from .moments import ellipses, mean_plane
from .moments_of_lamps import ellipses_of_lamp
from .near import blur_near
from .wide import blur_wide

# Measured on eight pools and suns against 256 suns of no width, error per variance of the map, within a factor of
# three: of cells that are g to a texel under ellipses with half axes of R texels, the least of _GRID_ERROR and _CHANGE
# R^2, over g^2 (1 + (g R)^3 / 2); of what comes over the border of n^2 texels, the least of _RIM_ERROR R^2 / n and
# _MOST_RIM; of taking the mean of all waves for each, _MEAN_ERROR.
_GRID_ERROR, _CHANGE, _RIM_ERROR, _MOST_RIM, _MEAN_ERROR = 2e-2, 0.07, 0.09, 0.05, 1.5e-4
_GRAIN = 4  # cells along a texel, at most
_VARIED = 3.2  # variance of light over its squared mean, for the choice of the grid: 0.3 to that was seen
_SHARE = 0.7  # of the tolerance, at most: finer cells cost more than beams that are split further
_LEAST = 0.1  # texels: smaller ellipses change nothing
_WIDE = 5.0  # texels: where transforms are quicker, and what crosses a border is no small part of a chart
_WIDEST = 2.0
_SOME = 1 << 12  # texels of an image tell how wide its ellipses are
_GOLDEN = (np.sqrt(5) - 1) / 2


class Disc:
    """What the size of a light, a Sun's disc or that of a Piece of a lamp, does to the maps of receivers under a
    LitWater.

    texels: Texels of the receivers; eta: of the water; tolerance: relative mean squared error that is good enough, of
    which `left` is for what is to be blurred; finest: the most cells along a texel. `seen` tells whether it does
    anything; `grain` is the number of cells along a texel that `blur` needs.
    """

    def __init__(self, lit, receivers, texels, eta, light, tolerance, finest=_GRAIN):
        self.grain, self.left, self._texels = 1, tolerance, texels
        self.seen = bool(_wide(light) and lit.area.any())
        if not self.seen:
            return
        found = _ellipses(lit, receivers, texels, eta, light)
        self._moments = [_bounded(own, t.resolution) for own, t in zip(found, texels, strict=True)]
        sizes = [2 * np.sqrt((m[0] + m[1]).mean() / 2) if m.size else 0.0 for m in self._moments]
        self.seen = max(sizes) > _LEAST
        if not self.seen:
            return
        lit_part = min(lit.area.sum() / sum(t.area.sum() for t in texels), 1.0)  # of the texels, if all light arrives
        varied = (1 + _VARIED) / lit_part - 1
        counts, axes = [m.shape[1] for m in self._moments], [_half_axes(m) for m in self._moments]
        self.grain, self._errors, own = _grid(axes, counts, _SHARE * tolerance / varied, finest)
        self.left = max(tolerance - varied * own, (1 - _SHARE) * tolerance)

    def doubt(self, light):
        """Relative mean squared error that `blur` leaves on texels with irradiance `light` (K,), blurred."""
        mean = light.mean() if len(light) else 0.0
        if not self.seen or not mean > 0:
            return 0.0
        parts = np.split(light, np.cumsum([m.shape[1] for m in self._moments])[:-1])
        squares = (error * part.var() * part.size for error, part in zip(self._errors, parts) if part.size)
        return sum(squares) / light.size / mean**2

    def blur(self, flux):
        """Flux (C, images * side^2) of the texels, of flux (C, images * (grain side)^2) of the cells."""
        if not self.seen:
            return flux
        side = self._texels[0].resolution
        cells = flux.reshape(len(flux), len(self._texels), self.grain * side, self.grain * side)
        images = [
            _blur_image(cells[:, k], texels, moments, self.grain)
            for k, (texels, moments) in enumerate(zip(self._texels, self._moments, strict=True))
        ]
        return np.stack(images, axis=1).reshape(len(flux), -1)

    def blur_light(self, light):
        """Irradiance (K,3) of the texels of all receivers, blurred, with no finer cells than these."""
        flux = light.T * np.concatenate([t.area for t in self._texels])
        cuts = np.cumsum([len(t.area) for t in self._texels])[:-1]
        images = np.zeros((3, len(self._texels), self._texels[0].resolution ** 2))
        for k, (texels, own) in enumerate(zip(self._texels, np.split(flux, cuts, axis=1), strict=True)):
            images[:, k, texels.texel] = own
        blurred = self.blur(images.reshape(3, -1)).reshape(images.shape)
        owned = [[t.gather(image)[0] for t, image in zip(self._texels, channel, strict=True)] for channel in blurred]
        return (np.array([np.concatenate(own) for own in owned]) / np.concatenate([t.area for t in self._texels])).T


def _wide(light):
    """Whether a light has a size."""
    return light.angle > 0 if isinstance(light, Sun) else isinstance(light, Piece) and light.half_axes.any()


def _ellipses(lit, receivers, texels, eta, light):
    """Second moments xx, yy, xy (3,K) [texel^2] of each receiver."""
    if isinstance(light, Sun):
        return ellipses(lit, receivers, texels, eta, light.angle / 2)
    return ellipses_of_lamp(mean_plane(lit), light.position, light.half_axes / 2, receivers, texels, eta)


def _bounded(moments, side):
    """Moments (3,K) of ellipses no wider than `_WIDEST` maps of `side` texels: what is wider evens the light out as
    much."""
    size = 2 * np.sqrt(moments[0] + moments[1])
    return moments * np.minimum(_WIDEST * side / np.maximum(size, np.finfo(float).tiny), 1.0) ** 2


def _half_axes(moments):
    """Half axes (k,) [texel] of some of the ellipses with moments (3,K), evenly drawn: where light grazes a receiver
    they are many times as long as elsewhere, and no mean speaks for all."""
    xx, yy, _ = moments[:, :: -(-moments.shape[1] // _SOME) or 1]
    return 2 * np.sqrt((xx + yy) / 2)


def _grid(axes, counts, enough, finest):
    """How many cells along a texel, up to `finest`, leave an error per variance of no more than `enough`, or where
    other causes leave much of that half of it; the error of each image, of `counts` texels under ellipses of which some
    have half axes `axes`, and that of all."""
    rest = np.array([_rest(*of) for of in zip(axes, counts, strict=True)])
    allowed = max(enough - np.average(rest, weights=counts), enough / 2)
    for grain in range(1, finest + 1):
        own = np.array([_grid_error(of, grain) for of in axes])
        if np.average(own, weights=counts) <= allowed:
            break
    return grain, own + rest, np.average(own + rest, weights=counts)


def _grid_error(axes, grain):
    """Error per variance that `grain` cells along a texel leave under ellipses with half axes (k,) [texel]."""
    errors = np.minimum(_GRID_ERROR, _CHANGE * axes**2) / (grain**2 * (1 + (grain * axes) ** 3 / 2))
    return errors.sum() / max(len(axes), 1)


def _rest(axes, count):
    """Error per variance of all else, on `count` texels under ellipses with half axes (k,) [texel]."""
    errors = np.minimum(_RIM_ERROR * axes**2 / np.sqrt(max(count, 1)), _MOST_RIM)
    return errors.sum() / max(len(axes), 1) + _MEAN_ERROR


def rings_within(sun, count):
    """Suns of no width, `count` of them, a multiple of four, that stand for the disc of a Sun: fours on rings round its
    middle, with the disc's centre, its second moments, and no moments of odd order."""
    many = count // 4
    turn = 2 * np.pi * (np.arange(many)[:, None] * _GOLDEN + np.arange(4)) / 4
    ring = np.sqrt((np.arange(many)[:, None] + 0.5) / many)
    return _narrow(sun, np.stack([ring * np.cos(turn), ring * np.sin(turn)], 2).reshape(-1, 2))


def within_disc(light, count, rng):
    """Lights of no width, `count` of them, whose directions are stratified over the disc of a Sun, or whose places are
    over a Piece."""
    along, turn = (np.arange(count) + rng.random(count)) / count, np.arange(count) * _GOLDEN + rng.random()
    ring, turn = np.sqrt(along), 2 * np.pi * turn
    places = np.stack([ring * np.cos(turn), ring * np.sin(turn)], 1)
    if not isinstance(light, Sun):
        if not light.round:
            places = np.sqrt(3) * (np.stack([along, turn / (2 * np.pi) % 1], 1) - 0.5)
        none = np.zeros_like(light.half_axes)
        return [replace(light, position=place, half_axes=none) for place in light.position + places @ light.half_axes]
    return _narrow(light, places)


def _narrow(sun, places):
    """Suns of no width at places (n,2) of a Sun's disc, whose radius is 1."""
    directions = sun.direction + np.tan(sun.angle / 2) * places @ sun_frame(sun.direction)[:2]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return [replace(sun, direction=direction, angle=0.0) for direction in directions]


def _blur_image(cells, texels, moments, grain):
    """Flux (C,side,side) of one image's texels, of its cells (C, grain side, grain side); moments (3,K)."""
    side = texels.resolution
    number = texels.chart[texels.triangle]
    chart = np.append(number, -1).astype(np.int32)[texels.home].reshape(side, side)
    home = texels.home.reshape(side, side)
    wide = np.unique(number[4 * (moments[0] + moments[1]) > _WIDE**2])
    if len(wide):
        near = np.where(np.isin(chart, wide), -1, chart)
        flux = blur_near(cells, near, home, moments * ~np.isin(number, wide), grain)
    else:
        flux = blur_near(cells, chart, home, moments, grain)
    for own in wide:
        window = _window(chart == own)
        for channel in flux:
            channel[window] = blur_wide(channel[window], chart[window] == own, home[window], moments)
    return flux


def _window(on):
    """The slices of an image that hold all that is `on`."""
    row, column = on.any(1).nonzero()[0], on.any(0).nonzero()[0]
    return slice(row[0], row[-1] + 1), slice(column[0], column[-1] + 1)
