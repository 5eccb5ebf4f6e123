"""What the frames of one animation have in common, so that choices do not jump between them.

Choices that one frame cannot make alone are made on one frame of the animation, the anchor. Every frame's light is a
function of the Anchor and of that frame: it does not matter which frames were solved before, by which process, or
whether at all.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .flat.level import Level
from .plan.choice import Plan
from .surface.reconstruct import Reconstruction
from .surface.smoothing import Smoothing


@dataclass(frozen=True)
class Anchor:
    """smoothing: how much the water's vertices are smoothed on water that is no rougher than the anchor's; plan: what
    was chosen there, where there was a choice; level: the plane of its water, where it may be taken as still."""

    smoothing: Smoothing = field(default_factory=Smoothing)
    plan: Plan | None = None
    level: Level | None = None


class Kept:
    """What one process keeps while it solves frames of one Anchor. All but the Anchor saves time only: the light is the
    same without it, bit for bit."""

    def __init__(self, anchor=None):
        from .flat.known import KnownStill  # these two load rays, which those that only hand anchors on do without
        from .trace.kept_light import KeptLight

        self.anchor = anchor or Anchor()
        self.reconstruction = Reconstruction(self.anchor.smoothing)
        self.still = KnownStill(self.anchor.level)
        self.light = KeptLight()

    def forget_light(self):
        """Keep no light of the frames before: what is solved next costs what a frame does in which all lamps move."""
        self.light = type(self.light)()
