"""What a ray carries, as rows of one array (R,k) that is linear over a beam.

First one row per channel that is absorbed differently: what arrives, of 1 W/m^2 of the source's power. Then, where the
water absorbs, what passed its surface; where rays may meet it again, what passed at the first meeting; and where the
light varies, what met it.
"""

from __future__ import annotations

import numpy as np


class Rows:
    """Which rows there are: sigma_a (3,) [1/m]; source: see `sources.py`; again: rays may meet the water twice.

    channel (3,): the row of what arrives in red, green and blue; count: how many such rows; total: how many rows.
    """

    def __init__(self, sigma_a, source, again=False):
        lit = source.power > 0  # a dark channel needs no row
        sigma, self.channel = np.unique(np.where(lit, sigma_a, sigma_a[np.argmax(lit)]), return_inverse=True)
        self._sigma, self.count = sigma, len(sigma)
        self.absorbing, self.again, self.varies = bool(sigma.any()), again, source.varies
        self.total = self.count + self.absorbing + self.again + self.varies

    def of(self, met, share, wet, landed, kept=1.0):
        """Rows (R,k) of rays that meet the water with `met`, of which `share` passes, and of that `kept` at all further
        meetings, and that travel wet (k,) [m] in it where they have landed (k,)."""
        entered = met * share
        passed = entered * kept
        if not (self.absorbing or self.again or self.varies):
            return passed[None]
        rows = [passed[None]]
        if self.absorbing:
            rows.insert(0, passed * np.exp(-self._sigma[:, None] * np.where(landed, wet, 0.0)))
        rows += [entered[None]] * self.again + [np.broadcast_to(met, passed.shape)[None]] * self.varies
        return np.concatenate(rows)

    def causes(self):
        """Names of what light can be lost to between the water's surface and where it arrives."""
        return "reflected", *(("second_meeting",) if self.again else ()), *(("absorbed",) if self.absorbing else ())

    def arriving(self, carried):
        """What arrives at a receiver, per channel (C,k)."""
        return carried[: self.count]

    def passed(self, carried):
        """What passed the water's surface (k,)."""
        return carried[self.count if self.absorbing else 0]

    def entered(self, carried):
        """What passed the water's surface, or was reflected, at the first meeting (k,)."""
        return carried[self.count + self.absorbing] if self.again else self.passed(carried)

    def met(self, flux, area):
        """What met the surface (k,), of rows that are flux over area (k,)."""
        return flux[-1] if self.varies else area
