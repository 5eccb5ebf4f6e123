"""The frames of one animation: what they share, and pictures of one that get better."""

from __future__ import annotations

from dataclasses import replace

from .anchor import Kept
from .reuse import Reuse

_STEP, _ROUGHEST = 100.0, 1.0  # of the tolerance, from pass to pass; an error as large as the mean


class Sequence:
    """Solves frame after frame; solve: `methods.solve`; settings: the Settings of all frames; anchor: the Anchor of
    their animation, of `methods.prepare`, without which each frame stands alone.

    The frames may come in any order, but for Settings.reuse. Raises ValueError for an impossible one.
    """

    def __init__(self, solve, settings, anchor=None):
        self._solve, self._settings = solve, settings
        self._kept, self._reuse = Kept(anchor), Reuse(settings.reuse)
        self._number = None

    def solve(self, number, scene, texels):
        """The Solution of the frame of this number; see `methods.solve`. Light is kept from the one before only."""
        solution = self._solve(scene, texels, self._settings, self._kept)
        if self._number != number - 1:
            self._reuse.forget()
        self._number = number
        return self._reuse.apply(scene, texels, solution)

    def rough(self, scene, texels):
        """Yield Solutions of the frame that is to be solved next, a rough one at once and better ones after it. They
        are of the mesh as it is; what `solve` gives is the same, bit for bit, with or without them."""
        rough = [self._settings.tolerance * _STEP]
        while rough[-1] * _STEP <= _ROUGHEST:
            rough.append(rough[-1] * _STEP)
        for tolerance in reversed(rough):
            yield self._solve(scene, texels, replace(self._settings, tolerance=min(tolerance, 1.0), surface="mesh"))
