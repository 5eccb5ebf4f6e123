"""The box that bounds the work of casters: an Empty in the scene, as its cube is drawn."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ...kernels.casters import Volume
from ...kernels.trace.volume import Box
from ..errors import DappleError

FACES = ("-X", "+X", "-Y", "+Y", "-Z", "+Z")  # in the order of Volume.culling
_FLAT = 1e-9  # of the box's longest side to the third power


@dataclass(frozen=True)
class Bounds:
    """The name of an Empty, and those of FACES, in its own axes, at which light that leaves ends."""

    name: str
    culling: tuple[str, ...] = ()


def read_volume(bounds, depsgraph):
    """The Volume of Bounds on the frame of an evaluated depsgraph; raises DappleError where it is no box."""
    found = bpy.data.objects.get(bounds.name)
    if found is None or found.type != "EMPTY":
        raise DappleError(f"The caustics volume '{bounds.name}' is no Empty of the file; choose it again.")
    matrix = np.array(found.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    matrix[:3, :3] *= found.empty_display_size
    longest = np.linalg.norm(matrix[:3, :3], axis=0).max()
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) <= _FLAT * longest**3:
        raise DappleError(f"The caustics volume '{bounds.name}' is flat; scale it so that it encloses something.")
    return Volume(matrix, tuple(face in bounds.culling for face in FACES))


def misses(volume, name, casters):
    """A warning on a Volume of that name that holds nothing of the casters: a list of at most one sentence."""
    box = Box(volume)
    if not casters or any(box.touches(c.positions[c.triangles]).any() for c in casters):
        return []
    return [f"No glass or metal reaches into the caustics volume '{name}', so none casts; move it, or choose none."]
