"""A glance at a frame: whether its waves are like those that a plan was made on, and then how much more they err.

A look at the water (`planner.py`) takes ten times as long. Waves of one animation mostly stay alike; what they err
goes with the contrast of the light, or with how far the mesh's normals are from its chords.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from zlib import crc32

import numpy as np

from ..surface.deviation import own_deviation, some_edges
from ..surface.reconstruct import is_smooth
from ..surface.window import glance

_ALIKE = 1.25  # times more or less: what is scaled by so little is scaled rightly


@dataclass(frozen=True)
class Glance:
    """contrast: mean square of the light over its squared mean, less 1, as a few hundred triangles tell; off: mean
    squared deviation of the mesh's normals from its chords, None where nothing hangs on it; both None for water that is
    no smooth height field; around: in numbers, all else that a plan hangs on."""

    contrast: float | None
    off: float | None
    around: tuple

    @classmethod
    def of(cls, scene, texels, settings, footprints):
        """The Glance at a Scene on Texels for Settings, without `off`; footprints: the Footprints, None without texels
        or lights."""
        some = glance(scene.water) if footprints is not None and is_smooth(scene.water) else None
        contrast = max(footprints.power(some) - 1, 0.0) if some is not None else None
        return cls(contrast, None, _around(scene, texels, settings))

    def closer(self, water):
        """The Glance with `off`, at its Water."""
        if self.contrast is None:
            return self
        deviation, length = own_deviation(water, some_edges(water.triangles))
        squared, area = (deviation * length) @ (deviation * length), length @ length
        return replace(self, off=float(squared / max(area, np.finfo(float).tiny)))

    def over(self, other):
        """How much more than on another frame the light's contrast and the mesh's deviation are, as two factors; None
        where the frames are not alike."""
        if self.around != other.around or (self.contrast is None) != (other.contrast is None):
            return None
        pairs = (self.contrast, other.contrast), (self.off, other.off)
        ratios = [one / two if two else 1.0 if one == two else np.inf for one, two in pairs]
        return tuple(ratios) if all(1 / _ALIKE <= ratio <= _ALIKE for ratio in ratios) else None


def _around(scene, texels, settings):
    """Settings, lights, and of each mesh how many its points are and a checksum of where, of the water how many."""
    how = settings.tolerance, settings.dispersion, settings.surface, settings.without, settings.resolution
    lights = tuple(
        (type(light).__name__, *(_plain(getattr(light, f.name)) for f in fields(light))) for light in scene.lights
    )
    groups = scene.receivers, scene.occluders, scene.casters
    meshes = tuple(tuple(_place(mesh) for mesh in group) for group in groups)
    counts = len(scene.water.positions), len(scene.water.triangles), *(len(t.texel) for t in texels)
    return how, lights, meshes, counts, float(scene.eta), _plain(scene.sigma_a)


def _place(mesh):
    return mesh.name, len(mesh.triangles), len(mesh.positions), crc32(np.ascontiguousarray(mesh.positions))


def _plain(value):
    return tuple(np.ravel(value).tolist()) if isinstance(value, (np.ndarray, tuple)) else value
