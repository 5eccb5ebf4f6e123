"""The physical terms that a solve can do without, each left out by not doing its work.

Terms that are a property of what is given are taken out of the Scene and the Settings here, for all methods alike; a
method that knows others looks for them in `Settings.without`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .casters import with_glass
from .scene import Sun

TERMS = {
    "fresnel": "all light passes the water's surface",
    "absorption": "the water and glass are clear",
    "dispersion": "all colours are bent alike",
    "disc": "light of suns comes from the middle of the disc",
    "occlusion": "objects that take no light block none, and nothing shades the water",
    "second_crossing": "light that passes the water does not meet it again",
    "reflection": "nothing is reflected off the water",
    "reconstruction": "the water is its mesh",
}


def check(without):
    """Raise ValueError for names that are no TERMS."""
    unknown = [name for name in without if name not in TERMS]
    if unknown:
        raise ValueError(f"without must be of {', '.join(TERMS)}, got {', '.join(map(repr, unknown))}")


def left_in(scene, settings):
    """(Scene, Settings) without what `settings.without` names, as far as both tell of it. Raises ValueError for names
    that are no terms."""
    check(settings.without)
    if "absorption" in settings.without:
        scene = replace(scene, sigma_a=np.zeros(3), casters=with_glass(scene.casters, sigma_a=np.zeros(3)))
    if "disc" in settings.without:
        lights = (replace(light, angle=0.0) if isinstance(light, Sun) else light for light in scene.lights)
        scene = replace(scene, lights=tuple(lights))
    if "occlusion" in settings.without:
        scene = replace(scene, occluders=())
    if "dispersion" in settings.without:
        scene = replace(scene, casters=with_glass(scene.casters, abbe=0.0))
        settings = replace(settings, dispersion=0.0)
    if "reconstruction" in settings.without:
        settings = replace(settings, surface="mesh")
    return scene, settings
