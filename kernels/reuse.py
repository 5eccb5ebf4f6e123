"""Temporal reuse: each texel keeps a share of what the frames before brought it, by an exponential moving average.

    kept = share * (kept in the frame before) + (1 - share) * new                                     [1, eq. 2]

The collection points of [1] are the texels, whose radius is that of a disc as large as they are. What was kept is
taken over only if the texel is where it was, within its radius, if its normal has turned by no more than a cosine of
0.9, and if it is of the same receiver [1, eq. 4]; else the texel starts anew. Caustics move, and what is kept of
them is where they were: docs/temporal.md measures it.

[1] Moreau & Doggett 2022, Real-Time Rendering of Indirectly Visible Caustics, section 3.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .scene import Diagnostics, Solution
from .status import Status, counts

_COSINE = 0.9
_SAYS = "what moved: of each texel's light {:.0%} is that of the frames before, so that moving light leaves a trail"


@dataclass
class _Kept:
    """What one receiver's texels kept: irradiance (K,3) [W/m^2]; and the Texels."""

    texels: object
    irradiance: np.ndarray


class Reuse:
    """What is kept from frame to frame, `share` of it each time. Raises ValueError for a share outside [0, 1)."""

    def __init__(self, share):
        if not 0 <= share < 1:
            raise ValueError(f"reuse must be a share from 0 to below 1, got {share}")
        self.share, self._kept = share, {}

    def forget(self):
        """Let the next frame start anew."""
        self._kept = {}

    def apply(self, scene, texels, solution):
        """The Solution of the next frame, of a Scene and its Texels, with what the frames before have left in it.

        Its books say what was kept as lost by "reused", below 0 where more came than went. Its estimated_error takes in
        how far the average is from the frame's own light.
        """
        if not self.share:
            return solution
        images, codes, squares = [], [], np.zeros(2)
        work = _copied(solution.diagnostics)
        for receiver, own, image, code in zip(scene.receivers, texels, solution.images, solution.status, strict=True):
            new = image.reshape(-1, 3)[own.texel]
            kept = self._mixed(receiver.name, own, new)
            self._kept[receiver.name] = _Kept(own, kept)
            images.append(own.image(kept))
            codes.append(_lit(code, own, kept))
            self._book(work, receiver.name, own, new, kept, squares)
        work.texels = counts(np.concatenate([code.ravel() for code in codes]))
        self._tell(work, squares, sum(own.area.sum() for own in texels))
        return Solution(tuple(images), tuple(codes), work)

    def _mixed(self, name, own, new):
        """Irradiance (K,3) of a receiver's Texels `own`: the average, where a texel has a past, else the new one."""
        if name not in self._kept:
            return new
        before = self._kept[name]
        old, sound = _same_place(before.texels, own)
        mixed = new.copy()
        mixed[sound] = self.share * before.irradiance[old[sound]] + (1 - self.share) * new[sound]
        return mixed

    def _book(self, work, name, own, new, kept, squares):
        """Put in the books what a receiver's texels hold now; squares (2,) gathers the sums of squared differences, and
        of light, by area."""
        more = own.area @ (kept - new) / work.map_scale
        work.flux_received[name] = work.flux_received[name] + more
        work.flux_lost["reused"] = work.flux_lost.get("reused", np.zeros(3)) - more
        squares += own.area @ ((kept - new).mean(1) ** 2), own.area @ new.mean(1)

    def _tell(self, work, squares, area):
        """Say what was reused, and how far that is from the frame's own light."""
        work.left_out = [*work.left_out, _SAYS.format(self.share)]
        square, light = squares
        if work.estimated_error is not None and light > 0:
            work.estimated_error = (np.sqrt(work.estimated_error) + np.sqrt(square * area) / light) ** 2


def _same_place(before, own):
    """Index (K,) into the Texels before of each of the Texels `own`, and whether (K,) the tests of [1] let it be."""
    if before is own:
        return np.arange(len(own.texel)), np.ones(len(own.texel), bool)
    if before.resolution != own.resolution:
        return np.zeros(len(own.texel), np.int64), np.zeros(len(own.texel), bool)
    where = np.full(own.resolution**2, -1)
    where[before.texel] = np.arange(len(before.texel))
    old = where[own.texel]
    moved = ((before.positions[old] - own.positions) ** 2).sum(1)
    turned = (before.normals[old] * own.normals).sum(1)
    return old, (old >= 0) & (moved <= own.area / np.pi) & (turned >= _COSINE)


def _lit(code, own, kept):
    """Status (H,W) with the dark texels lit that have kept light."""
    flat = code.ravel().copy()
    flat[own.texel[(flat[own.texel] == Status.DARK) & kept.any(1)]] = Status.LIT
    return flat.reshape(code.shape)


def _copied(work: Diagnostics):
    """The Diagnostics with books of their own."""
    return replace(work, flux_received=dict(work.flux_received), flux_lost=dict(work.flux_lost))
