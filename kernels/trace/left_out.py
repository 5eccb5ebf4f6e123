"""What the light of a Scene over its casters does not contain, in sentences."""

from __future__ import annotations

import numpy as np

from ..area_lamps import among, lamp_of
from ..scene import Sun
from ..splat.lander import BEYOND, LOST
from .part import Part, sizes
from .strays import odd
from .sun_disc import blur_of, directions

# Of a disc a texel wide, left out: squared error over the mean square, seen at the focus of a ball on texels' borders.
_AT_A_FOCUS = 1e-2


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
        elif count == 1 and isinstance(light, Sun) and light.angle > 0:
            wide = max(blur_of(scene, light, Part(own).of(texels)) for own in sizes(texels))
            if wide**2 * _AT_A_FOCUS > settings.tolerance:
                sentences.append(f"the disc of '{light.name}' over casters, {wide:.1f} texels wide")
    part = np.sum(work.flux_lost.get(LOST[BEYOND], 0.0)) / max(work.flux_in.sum(), np.finfo(float).tiny)
    if part > settings.tolerance:
        sentences.append(f"light that meets more than {settings.bounces} surfaces (bounces): {part:.1%} of all")
    return [*dict.fromkeys(sentences), *odd(scene, [cast.strays for cast in casts])]
