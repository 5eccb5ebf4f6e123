"""Light through water by code of its own: what the references are made of. Nothing here is shared with `kernels`.

A reference cuts the water into cells smaller than a texel. Every cell's light is refracted by Snell's law and lands on
a floor in closed form. From the true waves it is left on the texels as a box with the mean and the variance of the
cell's image along each axis, from a mesh as the triangle between the images of its corners.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

_NEWTON = 4  # steps from the plane z = 0 to a terrain


def refract(direction, normal, eta):
    """Refracted direction (3,...), per unit of its fall, and transmittance (...) by Snell and Fresnel.

    direction (3,) unit, of travel; normal (3,...) upward, of any length. The direction is returned as the way gone
    while sinking by one: (x, y, -1). Not for normals that face away from the light.
    """
    length = np.sqrt((normal * normal).sum(0))
    n = normal / length
    cos_i = -(direction[0] * n[0] + direction[1] * n[1] + direction[2] * n[2])
    cos_t = np.sqrt(1 - (1 - cos_i * cos_i) / eta**2)
    tangential = cos_i / eta - cos_t
    down = -(direction[2] / eta + tangential * n[2])
    x, y = ((direction[k] / eta + tangential * n[k]) / down for k in range(2))
    across = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    along = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    return x, y, 1 - (across**2 + along**2) / 2


@dataclass(frozen=True)
class Floor:
    """The square of `side` [m] round the origin at height z = relief(x, y), seen from above; plane where there is none.

    relief: returns height and slopes (each like x) for x, y.
    """

    side: float = 4.0
    relief: object = None

    def land(self, mx, my, mz, x, y):
        """Where the ray from (mx, my, mz) that goes (x, y) while it sinks by one meets the floor: its x and y."""
        sink = mz
        if self.relief is not None:
            for _ in range(_NEWTON):
                z, slope_x, slope_y = self.relief(mx + sink * x, my + sink * y)
                sink = sink + (mz - sink - z) / (1 + slope_x * x + slope_y * y)
        return mx + sink * x, my + sink * y

    def texel_area(self, resolution):
        """Area [m^2] of each texel (H,W): of the relief by 4 x 4 midpoints."""
        plan = (self.side / resolution) ** 2
        if self.relief is None:
            return np.full((resolution, resolution), plan)
        axis = ((np.arange(4 * resolution) + 0.5) / (4 * resolution) - 0.5) * self.side
        _, slope_x, slope_y = self.relief(*np.meshgrid(axis, axis))
        stretch = np.sqrt(1 + slope_x**2 + slope_y**2)
        return plan * stretch.reshape(resolution, 4, resolution, 4).mean((1, 3))


@dataclass
class Film:
    """Flux [W] per texel of a floor (H,W), with one texel round it for what lands beside."""

    floor: Floor
    resolution: int
    _flat: np.ndarray = field(init=False)

    def __post_init__(self):
        self._flat = np.zeros((self.resolution + 3) ** 2)

    def add(self, x, y, spread_x, spread_y, flux):
        """Leave flux (...) in boxes about (x, y) [m] with standard deviations spread_x, spread_y [m]."""
        scale = self.resolution / self.floor.side
        i, right = self._split(x * scale + self.resolution / 2, spread_x * scale)
        j, above = self._split(y * scale + self.resolution / 2, spread_y * scale)
        stride = self.resolution + 3
        cell = (j * stride + i).ravel()
        low = int(cell.min())
        cell -= low
        count = int(cell.max()) + 1
        upper = flux * above
        lower = flux - upper
        for shift, part in ((0, lower * (1 - right)), (1, lower * right)):
            self._flat[low + shift : low + shift + count] += np.bincount(cell, part.ravel())
        for shift, part in ((stride, upper * (1 - right)), (stride + 1, upper * right)):
            self._flat[low + shift : low + shift + count] += np.bincount(cell, part.ravel())

    def _split(self, at, deviation):
        """The texel (shifted by one) in which a box begins, and the part of the box that lies in the next one."""
        width = np.minimum(np.sqrt(12) * deviation, 1)  # wider boxes are the few where the light is thinnest
        low = at - width / 2
        first = np.clip(np.floor(low), -1, self.resolution)
        beyond = np.clip((low + width - first - 1) / np.maximum(width, 1e-12), 0, 1)
        return first.astype(np.int64) + 1, beyond

    def irradiance(self):
        """Mean irradiance (H,W) [W/m^2] of the texels; row 0 is at the least y."""
        side = self.resolution + 3
        flux = self._flat.reshape(side, side)[1:-2, 1:-2]
        return flux / self.floor.texel_area(self.resolution)
