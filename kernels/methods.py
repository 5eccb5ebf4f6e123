"""The methods, by the names that users type, and the choice between them."""

from __future__ import annotations

from dataclasses import replace

from . import conic_walk, photon_splat

METHODS = {"photon_splat": photon_splat.solve, "conic_walk": conic_walk.solve}
AUTO = "photon_splat"  # the one that finds all the light


def solve(scene, texels, settings):
    """The Solution of a Scene on Texels, one per receiver, by the method that `settings` asks for.

    Raises ValueError for a method that does not exist.
    """
    method = AUTO if settings.method == "auto" else settings.method
    if method not in METHODS:
        raise ValueError(f"method must be auto or one of {', '.join(METHODS)}, got {settings.method!r}")
    return METHODS[method](scene, texels, replace(settings, method=method))
