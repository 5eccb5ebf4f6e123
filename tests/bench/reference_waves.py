"""References of the true waves: a sum of sines, its heights and slopes exact at every point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .reference_light import Film, refract

_TILE = 126  # cells along a side of a block that fits the cache


@dataclass(frozen=True)
class Sines:
    """Waves of height sum a sin(k . (x, y) + phase): amplitude and wavelength [m], heading [rad], phase, each (n,)."""

    amplitude: np.ndarray
    wavelength: np.ndarray
    heading: np.ndarray
    phase: np.ndarray

    @property
    def wave_vector(self):
        """k (2,n) [1/m]."""
        return 2 * np.pi / self.wavelength * np.array([np.cos(self.heading), np.sin(self.heading)])

    def __call__(self, x, y):
        """Height and slopes at points x, y of any shape."""
        height, slope_x, slope_y = np.zeros((3, *np.shape(x)))
        for amplitude, kx, ky, phase in zip(self.amplitude, *self.wave_vector, self.phase, strict=True):
            angle = kx * x + ky * y + phase
            slope = amplitude * np.cos(angle)
            height += amplitude * np.sin(angle)
            slope_x += kx * slope
            slope_y += ky * slope
        return height, slope_x, slope_y

    def on_grid(self, x, y):
        """Height and slopes (len(y), len(x)) on the grid of two axes: sines of sums are sums of products."""
        kx, ky = self.wave_vector
        a, b = np.outer(x, kx) + self.phase, np.outer(y, ky)
        sin_a, cos_a, sin_b, cos_b = np.sin(a), np.cos(a), np.sin(b), np.cos(b)

        def products(of_sin, of_cos):
            left = np.hstack([cos_b, sin_b, cos_b, -sin_b])
            right = np.hstack([sin_a * of_sin, cos_a * of_sin, cos_a * of_cos, sin_a * of_cos])
            return left @ right.T

        none = np.zeros(len(kx))
        return (products(self.amplitude, none), *(products(none, self.amplitude * k) for k in (kx, ky)))


def by_waves(waves, level, low, high, direction, eta, floor, resolution, cells):
    """Irradiance (H,W) for 1 W/m^2 under waves at z = level over the rectangle low (2,) to high (2,).

    direction (3,): in which the light travels; cells: along each side of the rectangle.
    """
    film = Film(floor, resolution)
    step = (np.asarray(high) - low) / cells
    axes = [low[k] + (np.arange(-1, cells + 1) + 0.5) * step[k] for k in range(2)]
    for row in range(0, cells, _TILE):
        for column in range(0, cells, _TILE):
            x, y = axes[0][column : column + _TILE + 2], axes[1][row : row + _TILE + 2]
            _add_tile(film, waves, level, x, y, direction, eta, step.prod())
    return film.irradiance()


def _add_tile(film, waves, level, x, y, direction, eta, area):
    """Add the cells about the inner points of a grid of two axes."""
    height, slope_x, slope_y = waves.on_grid(x, y)
    normal = np.stack([-slope_x, -slope_y, np.ones_like(slope_x)])
    go_x, go_y, passed = refract(direction, normal, eta)
    landed = film.floor.land(x, y[:, None], level + height, go_x, go_y)
    entering = -(direction[0] * normal[0] + direction[1] * normal[1] + direction[2]) * area
    flux = (entering * passed)[1:-1, 1:-1]
    film.add(*(_mean(v) for v in landed), *(_deviation(v) for v in landed), flux)


def _mean(v):
    """Mean of a smooth function over each cell, from its values at their middles, to fourth order."""
    middle = v[1:-1, 1:-1]
    around = v[2:, 1:-1] + v[:-2, 1:-1] + v[1:-1, 2:] + v[1:-1, :-2]
    return middle + (around - 4 * middle) / 24


def _deviation(v):
    """Standard deviation of a smooth function over each cell."""
    across = (v[1:-1, 2:] - v[1:-1, :-2]) / 2
    along = (v[2:, 1:-1] - v[:-2, 1:-1]) / 2
    return np.sqrt((across * across + along * along) / 12)
