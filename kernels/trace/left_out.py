"""What the light of a Scene over its casters does not contain, in sentences."""

from __future__ import annotations

import numpy as np

from ..area_lamps import among, lamp_of
from ..scene import Sun
from ..splat.lander import BEYOND, LOST
from .part import Part, sizes
from .strays import odd
from .sun_disc import directions


def left_out(scene, texels, settings, work, casts):
    """Sentences (a list of str) on what the light of a Scene over its casters does not contain, by its books and those
    of its casts."""
    if not scene.casters:
        return []
    sentences = []
    for light in scene.lights:
        found = [directions(scene, light, Part(own).of(texels), settings.tolerance) for own in sizes(texels)]
        count, enough = max(found, key=lambda pair: pair[1])
        if count < enough:
            of = "directions within the disc" if isinstance(light, Sun) else "points"
            sentences.append(f"what is between {among(light) * count} {of} of '{lamp_of(light)}', over casters")
    part = np.sum(work.flux_lost.get(LOST[BEYOND], 0.0)) / max(work.flux_in.sum(), np.finfo(float).tiny)
    if part > settings.tolerance:
        sentences.append(f"light that meets more than {settings.bounces} surfaces (bounces): {part:.1%} of all")
    return [*dict.fromkeys(sentences), *odd(scene, [cast.strays for cast in casts])]
