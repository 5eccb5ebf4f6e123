"""The planner: of all that meets the tolerance, by what it predicts, the least time.

It looks at the waves - slopes and curvature against depth and texels (`still.py`, `surface/window.py`,
`surface/footprints.py`) - and at what there is: casters, lights, whether rays are needed. Choices are

- still water in closed form, where the waves hardly gather the light;
- beams of the mesh as it is, where its own error is small: the reconstruction is left out;
- beams of the smooth water, the complete solver, always.

Of beams the sun's disc is left out where it is too narrow to show, and dispersion where colours part by too little. All
else that the complete solver knows - reflection, light that meets the water again, shadows - it does only where its own
certain tests leave any.

A plan is a function of the frame and of the plan of the animation's anchor, whose choice is kept while it meets the
tolerance and costs no more than twice the best: so frames do not depend on each other, nor flicker between choices. On
a frame that a glance tells to be like the anchor (`glance.py`), what the anchor's waves err is scaled, and the water is
not looked at.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..splat.plane import one_plane
from ..surface.footprints import Footprints
from ..surface.reconstruct import is_smooth, margin
from ..surface.share import SHARE
from ..surface.window import look
from . import cost
from .choice import FLAT, MESH, SMOOTH, Choice, Plan
from .glance import Glance
from .still import still_error

_DEARER = 2.0  # times the best: what an anchor's choice may cost
_FAR = 3.0  # times the tolerance
_SMALL = 0.15  # of the tolerance: the effect of a term that may be left out
_PARTED = 1.0  # of the light's variance, by a texel between colours: rather too much
_PARTS = range(1, 9)


def planned(scene, texels, settings, smoothing, anchor=None):
    """The Plan of a Scene on Texels for Settings; smoothing: that of the animation; anchor: its Plan, if there is
    one."""
    footprints = Footprints.of(scene, texels)
    seen = Glance.of(scene, texels, settings, footprints)
    if anchor is not None and anchor.glance is not None:
        alike = _scaled(anchor, seen if anchor.of_one else seen.closer(scene.water), settings.tolerance)
        if alike is not None:
            return alike
    plan = _looked(scene, texels, settings, smoothing, anchor, footprints, seen)
    return replace(plan, glance=seen if plan.of_one else seen.closer(scene.water))


def _scaled(anchor, seen, tolerance):
    """The anchor's Plan for a frame of which a Glance was `seen`; None where that is not alike, or another choice would
    be made."""
    factors = seen.over(anchor.glance)
    if factors is None:
        return None
    contrast, off = factors
    scale = {FLAT: contrast, MESH: off, SMOOTH: 1.0}
    choices = tuple(replace(choice, error=scale[choice.kind] * choice.error) for choice in anchor.choices)
    chosen = _chosen(choices, tolerance, anchor)
    if chosen.kind != anchor.choice.kind or not chosen.fits(tolerance):
        return None
    measures = dict(anchor.measures, waves=contrast * anchor.measures["waves"])
    if "power" in measures:
        measures["power"] = 1 + contrast * (measures["power"] - 1)
        measures["mesh"] *= off
    return Plan(chosen, choices, measures, seen)


def _looked(scene, texels, settings, smoothing, anchor, footprints, seen):
    """The Plan of a frame by all that there is to look at; see `planned`."""
    lights = 3 if settings.dispersion else 1
    texel_count = sum(len(t.texel) for t in texels)
    rays = bool(texels) and one_plane(scene, texels) is None
    counts = cost.Counts(len(scene.water.triangles), texel_count, max(len(scene.lights), 1) * lights, rays)
    still, shaded = np.inf, False
    if seen.contrast is None or seen.contrast <= _FAR * settings.tolerance:
        still, shaded = still_error(scene, texels)
    bare = () if shaded or scene.occluders else ("occlusion",)
    flat = Choice(FLAT, "flat", bare, still, cost.flat(counts))
    if flat.fits(settings.tolerance) and flat.seconds <= cost.beams(counts):  # nothing is cheaper
        return Plan(flat, (flat,), {"waves": still})
    measures = {"waves": still, "casters": len(scene.casters), **_seen(scene, footprints, settings, smoothing)}
    choices = [flat, *_beams(scene, settings, counts, measures)]
    return Plan(_chosen(choices, settings.tolerance, anchor), tuple(choices), measures)


def _seen(scene, footprints, settings, smoothing):
    """What a window of the water tells: {power: mean square of the light over its squared mean; mesh: the mesh's own
    error, inf where it is not known; disc and dispersion: the errors of leaving them out; in 1, in 2, ...: that of
    k x k parts of each triangle}."""
    triangles = look(scene.water, smoothing) if footprints is not None and is_smooth(scene.water) else None
    if triangles is None:
        return {"power": 1.0, "mesh": np.inf}
    power = footprints.power(triangles)
    errors = footprints.tessellated(triangles, _PARTS) / power
    seen = {
        "power": power,
        "mesh": footprints.own(triangles) / power,
        "disc": (1 - 1 / power) * footprints.disc(triangles),
    }
    if settings.dispersion:
        seen["dispersion"] = (1 - 1 / power) * _PARTED * footprints.parted(settings.dispersion) ** 2
    return {**seen, **{f"in {k}": error for k, error in zip(_PARTS, errors, strict=True)}}


def _beams(scene, settings, counts, measures):
    """The Choices by beams: of the mesh as it is, and of the smooth water where it is asked for and there is one."""
    small = [t for t in ("disc", "dispersion") if measures.get(t, np.inf) <= _SMALL * settings.tolerance]
    error = sum(measures[t] for t in small)
    if "dispersion" in small:
        counts = replace(counts, lights=counts.lights // 3)
    small = [t for t in small if measures[t] > 0]
    disc = "disc" not in small and any(getattr(light, "angle", 0.0) > 0 for light in scene.lights)
    if settings.surface != "auto" or not is_smooth(scene.water):
        return [Choice(SMOOTH, "photon_splat", tuple(small), error, cost.beams(counts, None, disc))]
    enough = [k for k in _PARTS if margin(k) * measures.get(f"in {k}", np.inf) <= SHARE * settings.tolerance]
    smooth = cost.beams(counts, enough[0] if enough else _PARTS[-1] if "in 1" in measures else 2, disc)
    mesh = cost.beams(counts, None, disc)
    return [
        Choice(MESH, "photon_splat", ("reconstruction", *small), measures["mesh"] + error, mesh),
        Choice(SMOOTH, "photon_splat", tuple(small), error, smooth),
    ]


def _chosen(choices, tolerance, anchor):
    """The cheapest of the Choices that fit, or the anchor's kind while that is not too dear; the last always fits."""
    fit = [choice for choice in choices if choice.fits(tolerance)] or choices[-1:]
    best = min(fit, key=lambda choice: choice.seconds)
    kept = [c for c in fit if anchor is not None and c.kind == anchor.choice.kind]
    return kept[0] if kept and kept[0].seconds <= _DEARER * best.seconds else best
