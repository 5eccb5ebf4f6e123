"""Whether a beam is ready to be landed whole: how large it is on the texels, what error that leaves, and whether
anything may hide between its rays."""

from __future__ import annotations

import numpy as np

from .lander import OTHER, UNLIT
from .prediction import cut_off, predict

_HIDDEN = 1.0  # texels: parts smaller than this none of whose rays lands, near light that does, land by a point


class Readiness:
    """Of beams that a lander follows to maps of side^2 texels of texel_area (images,) [m^2]; tolerance and sight as of
    `beams.splat`. finest [m^2]: of the texels; uneven: whether what passes differs from ray to ray; spent: what beams
    took of the tolerance that had no choice."""

    def __init__(self, lander, texel_area, side, tolerance, sight):
        self._lander, self._rows, self._resolution = lander, lander.rows, side
        self._tolerance, self._sight = tolerance, sight
        self.texel_area, self.finest = np.asarray(texel_area), np.min(texel_area)
        self.uneven, self.spent = lander.rows.varies, 0.0

    def light(self, nodes, six):
        """Mean and range (n,) over beams six (6,n) of what passes the water, where it is uneven; else 1 and 0."""
        if not self.uneven:
            return 1.0, 0.0
        passed = np.take(self._rows.passed(nodes.carried), six)
        return passed.mean(0), np.ptp(passed, axis=0)

    def size(self, nodes, six, area):
        """How many texels (n,) beams are across, where they meet the receiver if the light of a lamp spreads them."""
        return self.widest(nodes, six, area) if self._rows.varies else self.across(nodes, six, area)

    def across(self, nodes, six, area):
        """How many of the finest texels that their rays land on (n,) beams are across; where none lands, of the
        coarsest."""
        if len(self.texel_area) == 1:
            return np.sqrt(2 * area / self.finest)
        chart = np.take(nodes.chart, six)
        texel = np.where(chart < 0, self.texel_area.max(), np.take(self.texel_area, self.image(chart))).min(0)
        return np.sqrt(2 * area / texel)

    def widest(self, nodes, six, area):
        """As `across`, on the receiver and not where the beams start."""
        return self.across(nodes, six, area) * np.take(nodes.spread, six).max(0)

    def ready(self, chart, error, size, clear, weight=None):
        """Whether (n,) beams, of errors `error` or inf where their rays do not agree, need no closer look; clear (n,):
        nothing can hide between their rays.

        Those of the least errors, such that their sum takes no more than half of what is left of the tolerance: the
        other half is for the parts of the others.
        """
        known = np.isfinite(error)
        most = cut_off(error[known], (self._tolerance - self.spent) / 2, None if weight is None else weight[known])
        seen = (clear & (chart != UNLIT)) | (
            size < np.where(self.dark(chart), _HIDDEN * self._lander.fine, self._sight)
        )
        return known & (error <= (most if weight is None else most * weight)) & seen

    def dark(self, chart):
        """Whether (n,) beams whose rays all end so, by their chart, may yet hold light that lands elsewhere."""
        return chart < 0 if self._lander.hides else chart == OTHER

    def image(self, chart):
        """Which map (n,) charts are on, the first for none."""
        return np.take(self._lander.image, np.maximum(chart, 0))

    def predict(self, bent, chart, x, y, area, light):
        """Sum of squared errors (n,) that spreading evenly leaves on the texels, see `prediction.predict`; inf where
        rays do not agree."""
        flux = area / np.take(self.texel_area, self.image(chart))
        error = np.where(chart < 0, 0.0, predict(bent, x, y, flux, light, self._resolution))
        return np.where(np.isfinite(bent), error, np.inf)
