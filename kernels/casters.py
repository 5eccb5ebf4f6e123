"""What else than the water casts: glass and mirrors, and the volume that bounds them. Arrays in, no Blender."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .checks import check_shaded


@dataclass(frozen=True)
class Glass:
    """A smooth dielectric that encloses what is behind its normals: eta, its index of refraction over that of air;
    sigma_a (3,) [1/m] in it; reflects and transmits (3,): colours by which each meeting multiplies Fresnel's shares;
    abbe: its Abbe number, 0 for that of `scene.Settings.dispersion`."""

    eta: float
    sigma_a: np.ndarray = field(default_factory=lambda: np.zeros(3))
    reflects: np.ndarray = field(default_factory=lambda: np.ones(3))
    transmits: np.ndarray = field(default_factory=lambda: np.ones(3))
    abbe: float = 0.0


@dataclass(frozen=True)
class Mirror:
    """A smooth opaque surface that reflects on both sides: f0 and f90 (3,), its reflectance along the normal and at
    grazing incidence, with Schlick's curve between them."""

    f0: np.ndarray
    f90: np.ndarray


@dataclass(frozen=True)
class Caster:
    """A mesh other than the water that bends light or mirrors it: arrays as those of Water, and its Glass or Mirror.

    Raises ValueError for shapes and indices that do not fit.
    """

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    normal_triangles: np.ndarray
    material: Glass | Mirror

    def __post_init__(self):
        check_shaded(self)


@dataclass(frozen=True)
class Volume:
    """A box that bounds the work of the casters: matrix (4,4) takes the cube [-1, 1]^3 to it, in the world; culling
    (6,) bool, the faces -x, +x, -y, +y, -z, +z of that cube through which light that leaves is dropped."""

    matrix: np.ndarray
    culling: tuple[bool, ...] = (False,) * 6

    def __post_init__(self):
        if np.shape(self.matrix) != (4, 4) or len(self.culling) != 6:
            raise ValueError(f"matrix must have shape (4, 4) and culling (6,), got {np.shape(self.matrix)}")


def with_glass(casters, **changes):
    """The casters (a tuple of Caster), each of glass with changes to its Glass."""
    return tuple(
        replace(c, material=replace(c.material, **changes)) if isinstance(c.material, Glass) else c for c in casters
    )
