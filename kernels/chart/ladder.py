"""The rungs of the ladder, each with the settings that it is measured at."""

from __future__ import annotations

from dataclasses import dataclass, replace

from .. import presets
from ..methods import METHODS

AUTO = "auto"
PRESETS = {name.capitalize(): tolerance for name, tolerance in presets.PRESETS.items()}
_GRIDS = 128, 256, 512, 1024
_ASKED = 1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4


def _asked(*tolerances, **fixed):
    return tuple((f"{tolerance:g}", {"tolerance": tolerance, **fixed}) for tolerance in tolerances)


@dataclass(frozen=True)
class Rung:
    """name: what its curve is called; method: a key of METHODS or "auto"; knobs: pairs of a label and the Settings that
    a point of the curve is measured at; over_water: whether it is nothing without water."""

    name: str
    method: str
    knobs: tuple
    over_water: bool = True

    def settings(self, base):
        """(label, Settings) of each point, for Settings that say all else."""
        return [(label, replace(base, method=self.method, **changed)) for label, changed in self.knobs]


_KNOWN = (
    Rung("flat", "flat", (("still water", {}),)),
    Rung("sun_map", "sun_map", (("a look", {}),)),
    Rung("caustic_map", "caustic_map", tuple((f"{n} points", {"grid": n}) for n in _GRIDS), over_water=False),
    Rung("photon_splat", "photon_splat", _asked(*_ASKED), over_water=False),
    Rung(
        "photon_splat, mesh as it is", "photon_splat", tuple((k, {**v, "surface": "mesh"}) for k, v in _asked(*_ASKED))
    ),
    Rung("conic_walk, first root", "conic_walk", (("one path", {"first_root": True}),)),
    Rung("conic_walk", "conic_walk", _asked(1e-1, 1e-2, 1e-3)),
    Rung(AUTO, AUTO, tuple((name, {"tolerance": value}) for name, value in PRESETS.items()), over_water=False),
)


def rungs(scene, settings, methods=None):
    """The Rungs that apply to a Scene under Settings: of the methods named, or of all that there are; auto last."""
    wanted = (*METHODS, AUTO) if methods is None else methods
    known = [rung for rung in _KNOWN if rung.method in wanted and (rung.method in METHODS or rung.method == AUTO)]
    water = len(scene.water.triangles) > 0
    known = [rung for rung in known if water or not rung.over_water]
    if settings.surface == "mesh":
        known = [rung for rung in known if not any("surface" in changed for _, changed in rung.knobs)]
    return known
