"""Photons as points: on one plane, in closed form, or on the first of any surfaces, by rays.

Both keep the flux of every photon in bins, one per texel of the images and one per cause of loss.
"""

from __future__ import annotations

import numpy as np

from .lander import DARK, LOST
from .photons import Forms, bend

_PENDING = 1 << 19  # photons between two bincounts: their bins are larger than the cache


class Bins:
    """Flux per bin in C channels: `count` texels of images, then one bin for each name of `lost`; and `met`, the flux
    of all photons."""

    def __init__(self, count, lost, channels=1):
        self.count, self.lost = count, lost
        self.met = 0.0
        self._cell = np.empty(_PENDING, np.int64)
        self._flux = np.empty((channels, _PENDING))
        self._filled = 0
        self._bins = np.zeros((channels, count + len(lost)))

    def add(self, cell, flux):
        """Add flux (C,n) to bins cell (n,), n at most _PENDING."""
        if self._filled + len(cell) > _PENDING:
            self._flush()
        block = slice(self._filled, self._filled + len(cell))
        self._cell[block], self._flux[:, block] = cell, flux
        self._filled += len(cell)

    def add_lost(self, cause, flux):
        """Add flux, a number or (C,), to the bin of a cause."""
        self._bins[:, self.count + self.lost.index(cause)] += flux

    def take(self):
        """Flux of the texel bins (C,count), {cause: (C,)} and met; all start again from zero."""
        self._flush()
        bins, self._bins = self._bins, np.zeros_like(self._bins)
        met, self.met = self.met, 0.0
        return bins[:, : self.count], {name: bins[:, self.count + k] for k, name in enumerate(self.lost)}, met

    def _flush(self):
        cell = self._cell[: self._filled]
        for bins, flux in zip(self._bins, self._flux[:, : self._filled], strict=True):
            bins += np.bincount(cell, flux, minlength=len(bins))
        self._filled = 0


class Rays:
    """Photons land on the first surface that their ray meets."""

    def __init__(self, lander, receivers, resolution, lit, shadowed):
        self._lander, self._shadowed, self._resolution = lander, shadowed, resolution
        self._causes = {code: receivers * resolution**2 + k for k, code in enumerate(LOST)}
        self._rows = lander.rows
        lost = (*LOST.values(), *self._rows.causes())
        self._bins = Bins(receivers * resolution**2, lost, self._rows.count)
        self._forms = Forms(lit, lit.frame.T, lit.frame.T)  # positions and normals back in the world

    def add(self, triangles, points, flux):
        """Land one batch of `photons.batches`."""
        values, _ = self._forms.at(triangles, points)
        shaded = np.repeat(self._shadowed[triangles], points.shape[1])
        nodes = self._lander.land(values[:3], values[3:6], shaded)
        side = self._resolution
        i, j = (np.clip(np.nan_to_num(v), 0, side - 1).astype(np.int64) for v in (nodes.x, nodes.y))
        cell = (np.take(self._lander.image, np.maximum(nodes.chart, 0)) * side + j) * side + i
        for code, lost in self._causes.items():
            cell[nodes.chart == code] = lost
        self._book(cell, nodes.chart, np.repeat(flux, points.shape[1]), nodes.carried)

    def _book(self, cell, chart, area, carried):
        """Leave what photons of area (n,) carry in the bins cell (n,)."""
        flux = area * carried
        met, entered, passed = self._rows.met(flux, area), self._rows.entered(flux), self._rows.passed(flux)
        landed, lit = chart >= 0, ~np.isin(chart, DARK)
        kept = np.where(landed, self._rows.arriving(flux), np.where(lit, passed, met))
        self._bins.add(cell, kept)
        self._bins.add_lost("reflected", (met - entered)[lit].sum())
        if self._rows.again:
            self._bins.add_lost("second_meeting", (entered - passed)[lit].sum())
        if self._rows.absorbing:
            self._bins.add_lost("absorbed", (passed - kept)[:, landed].sum(1))
        self._bins.met += met.sum()

    def take(self):
        """Flux per texel of all images (C,n), per cause of loss (C,), and of all photons; starts again from zero."""
        return self._bins.take()


class Plane:
    """Photons of a Sun land through clear water on the only receiver, of which `plane.one_plane` gives the map: no ray
    is needed."""

    def __init__(self, own, eta, lit, plane, fresnel=True):
        self._resolution, self._eta, self._fresnel = own.resolution, eta, fresnel
        self._off = np.flatnonzero(~own.whole)  # the ring past the border takes what rounds; here it is off the plane
        local = plane[:, :3] @ lit.frame.T
        self._offset = plane[:, 3]
        self._fall = -local[:, 2] / eta  # of d / eta, since light travels along -z
        self._forms = Forms(lit, local, local)
        self._bins = Bins(own.resolution**2, ("missed", "reflected"))

    def add(self, triangles, points, flux):
        """Land one batch of `photons.batches`."""
        (height, x, y, fall, dx, dy, along_sun), squared = self._forms.at(triangles, points)
        g, passed = bend(along_sun, squared, self._eta, self._fresnel)
        fall *= g
        fall += self._fall[0]
        tau = -(height + self._offset[0]) / fall
        x += self._offset[1] + tau * (dx * g + self._fall[1])
        y += self._offset[2] + tau * (dy * g + self._fall[2])
        side = self._resolution
        inside = (x >= 0) & (x < side) & (y >= 0) & (y < side) & (tau > 0)
        cell = y.astype(np.int64) * side + x.astype(np.int64)
        end = side * side
        cell[~inside] = end
        passed = passed.reshape(len(triangles), -1)
        through = passed * flux[:, None]
        self._bins.add(cell, through.ravel())
        met = flux.sum() * points.shape[1]
        self._bins.add_lost("reflected", met - through.sum())
        self._bins.met += met

    def take(self):
        """As `Rays.take`."""
        flux, lost, met = self._bins.take()
        lost["missed"] = lost["missed"] + flux[:, self._off].sum(1)
        flux[:, self._off] = 0
        return flux, lost, met
