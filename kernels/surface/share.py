"""Which surface of the water is solved, and how it shares the tolerance with what is solved on it.

Inside, errors are mean squared over the squared mean of the light; the tolerance, and what is estimated in the end, are
over its mean square, which is more by the light's variance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..scene import Scene, Settings
from .reconstruct import Need

SHARE = 0.7  # of the tolerance, at most: its parts cost most, and half the error takes 1.4 times as many
_AS_ASKED = "the mesh as it is, as was asked for"


@dataclass(frozen=True)
class Surface:
    """scene: with the water to solve; settings: with what of the tolerance is left, over the squared mean; sentence: on
    the surface; error: what it leaves, over the squared mean; planned: what a plan has left out, over the mean square.
    """

    scene: Scene
    settings: Settings
    sentence: str
    error: float = 0.0
    planned: float = 0.0

    @classmethod
    def of(cls, scene, texels, settings, reconstruction, plan, known=None):
        """The Surface of a Scene on Texels for Settings, by a Reconstruction; plan: the Plan, if there is one; known:
        the sentence, for methods that take the water as it is."""
        if known:
            return cls(scene, settings, known)
        if not len(scene.water.triangles):
            return cls(scene, settings, "there is no water")
        out = plan.choice.error if plan is not None else 0.0
        tolerance, sentence, error = max(settings.tolerance - out, (1 - SHARE) * settings.tolerance), _AS_ASKED, 0.0
        power = plan.measures["power"] if plan is not None else 1.0
        if plan is not None and "reconstruction" in plan.choice.without:
            sentence = "the mesh as it is, which is fine enough for such waves"
        if settings.surface == "auto":
            water, sentence = reconstruction.apply(scene.water, Need.of(scene, texels, SHARE * tolerance))
            scene, error, power = replace(scene, water=water), reconstruction.error, max(power, reconstruction.power)
        tolerance *= power
        left = max(tolerance - error, (1 - SHARE) * tolerance)
        return cls(scene, replace(settings, tolerance=left), sentence, error, out)

    def estimate(self, answer):
        """The estimated error of a Solution over the mean square of its light, with the surface's; None where the
        method has none."""
        own = answer.diagnostics.estimated_error
        return None if own is None else (own + self.error) / answer.power + self.planned
