"""Light that goes astray between media: it leaves a body that it is not in, or goes into one and is never out of it.

Meshes that are closed, with their normals outwards, send none astray. Holes do, and faces of two things in one place,
of which a ray that starts off the one misses the other.
"""

from __future__ import annotations

import numpy as np

from ..rays import MISS

_ODD = 1e-3  # of the light over casters: more of it that goes astray is said
_MEND = "close the mesh, turn its normals outwards, and let no face of it lie in a face of something else"


class Strays:
    """Books, over the power of one light of a Scene, of Surfaces: flux of all, out (casters + 1,) of what leaves each
    caster and the water unduly, within (1,) what is never out of a body."""

    def __init__(self, scene, surfaces):
        sizes = [len(mesh.triangles) for mesh in (*scene.casters, scene.water)]
        self._ends, self._crossings = surfaces.solid + np.cumsum(sizes), surfaces.crossings
        self._bounded = surfaces.media.bounded
        self.flux, self.out, self.within = 0.0, np.zeros(len(sizes)), 0.0

    def add(self, rays, end, flux):
        """Count Rays that end on `end` (k,) with flux (k,)."""
        self.flux += flux.sum()
        astray = rays.astray > 0
        if astray.any():
            mesh = np.searchsorted(self._ends, rays.astray[astray] - 1, "right")
            self.out += np.bincount(mesh, flux[astray], len(self.out))
        inside = np.take(self._crossings.masks, rays.state) & self._bounded > 0
        self.within += flux[(end == MISS) & inside & ~astray].sum()


def odd(scene, books):
    """Sentences (a list of str) on what goes astray over a Scene, of Strays of its lights."""
    least = _ODD * sum(book.flux for book in books)
    out = sum((book.out for book in books), np.zeros(len(scene.casters) + 1))
    total, sentences = least / _ODD, []
    for name in dict.fromkeys(mesh.name for mesh in (*scene.casters, scene.water)):
        own = sum(flux for mesh, flux in zip((*scene.casters, scene.water), out, strict=True) if mesh.name == name)
        if own > least:
            sentences.append(
                f"the right way of {own / total:.1%} of the light over casters, which comes out of '{name}' though it "
                f"never went in: {_MEND}"
            )
    within = sum(book.within for book in books)
    if within > least:
        sentences.append(
            f"the right way of {within / total:.1%} of the light over casters, which goes into glass and never comes "
            f"out: {_MEND}"
        )
    return sentences
