"""What a ray carries, as rows of one array (R,k) that is linear over a beam.

First one row per channel that is absorbed differently: what arrives, of 1 W/m^2 of the source's power. Then, where the
water absorbs, what passed its surface; and where the light varies, what met it.
"""

from __future__ import annotations

import numpy as np


class Rows:
    """Which rows there are: sigma_a (3,) [1/m]; source: see `sources.py`; clear: no absorption on this way.

    channel (3,): the row of what arrives in red, green and blue; count: how many such rows; total: how many rows.
    """

    def __init__(self, sigma_a, source, clear=False):
        lit = source.power > 0  # a dark channel needs no row
        sigma, self.channel = np.unique(np.where(lit, sigma_a, sigma_a[np.argmax(lit)]), return_inverse=True)
        self._sigma = sigma * (not clear)
        self.count = len(sigma)
        self.absorbing, self.varies = bool(sigma.any()), source.varies
        self.total = self.count + self.absorbing + self.varies

    def of(self, met, share, tau, landed):
        """Rows (R,k) of rays that meet the water with `met`, of which `share` passes, and travel tau (k,) [m] in it
        where they have landed (k,)."""
        passed = met * share
        if not self.absorbing and not self.varies:
            return passed[None]
        arriving = (
            passed * np.exp(-self._sigma[:, None] * np.where(landed, tau, 0.0)) if self.absorbing else passed[None]
        )
        rows = [arriving, *([passed[None]] if self.absorbing else ()), *([met[None]] if self.varies else ())]
        return np.concatenate(rows)

    def arriving(self, carried):
        """What arrives at a receiver, per channel (C,k)."""
        return carried[: self.count]

    def passed(self, carried):
        """What passed the water's surface (k,)."""
        return carried[self.count if self.absorbing else 0]

    def met(self, flux, area):
        """What met the surface (k,), of rows that are flux over area (k,)."""
        return flux[-1] if self.varies else area
