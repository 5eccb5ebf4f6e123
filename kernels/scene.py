"""What a solver is given: water, casters, receivers, occluders, lights. Arrays in, no Blender.

Meshes are world space, metres, float64; triangles index vertices and are wound counter-clockwise seen from the side
that the normals point to.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from .casters import Caster, Volume
from .checks import check_index, check_shaded, check_shape
from .status import Status

WATER_IOR = 1.333


@dataclass(frozen=True)
class Water:
    """The refracting surface of one frame.

    positions (V,3) [m]; triangles (T,3) int into positions; normals (N,3), as shaded, unit; normal_triangles (T,3) int
    into normals: the same array as `triangles` for smooth shading, a row of its own per face or corner otherwise;
    twins (3T,) int from `halfedges.build_twins`. Raises ValueError for shapes and indices that do not fit.
    """

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    normal_triangles: np.ndarray
    twins: np.ndarray

    def __post_init__(self):
        check_shaded(self)
        if self.twins.shape != (3 * len(self.triangles),):
            raise ValueError(f"twins must have shape ({3 * len(self.triangles)},), got {self.twins.shape}")


@dataclass(frozen=True)
class Receiver:
    """A mesh that takes the light on its front, the side that sees its triangles wound counter-clockwise: positions
    (V,3) [m]; triangles (T,3); uvs (T,3,2), one per corner."""

    name: str
    positions: np.ndarray
    triangles: np.ndarray
    uvs: np.ndarray

    def __post_init__(self):
        check_shape("positions", self.positions, 3)
        check_shape("triangles", self.triangles, 3)
        check_shape("uvs", self.uvs, 3, 2)
        check_index("triangles", self.triangles, len(self.positions))
        if len(self.uvs) != len(self.triangles):
            raise ValueError(f"uvs must have shape ({len(self.triangles)}, 3, 2), got {self.uvs.shape}")


@dataclass(frozen=True)
class Occluder:
    """A mesh that only blocks light: positions (V,3) [m]; triangles (T,3)."""

    name: str
    positions: np.ndarray
    triangles: np.ndarray

    def __post_init__(self):
        check_shape("positions", self.positions, 3)
        check_shape("triangles", self.triangles, 3)
        check_index("triangles", self.triangles, len(self.positions))


@dataclass(frozen=True)
class Sun:
    """Parallel light: direction (3,) of travel, irradiance (3,) RGB [W/m^2] across it, angle [rad] of the disc."""

    name: str
    direction: np.ndarray
    irradiance: np.ndarray
    angle: float = 0.0

    def __post_init__(self):
        length = np.linalg.norm(self.direction)
        if np.shape(self.direction) != (3,) or not abs(length - 1.0) < 1e-6:
            raise ValueError(f"direction must be a unit vector of shape (3,), got {self.direction}")
        if np.shape(self.irradiance) != (3,):
            raise ValueError(f"irradiance must have shape (3,), got {np.shape(self.irradiance)}")


@dataclass(frozen=True)
class Point:
    """Light from one point: position (3,) [m], intensity (3,) RGB [W/sr], radius [m] of the lamp's sphere."""

    name: str
    position: np.ndarray
    intensity: np.ndarray
    radius: float = 0.0

    def __post_init__(self):
        for name in ("position", "intensity"):
            if np.shape(getattr(self, name)) != (3,):
                raise ValueError(f"{name} must have shape (3,), got {np.shape(getattr(self, name))}")


@dataclass(frozen=True)
class Spot(Point):
    """A Point that shines in a cone only; intensity is that on its axis.

    frame (3,3) takes a direction of travel to one in which the cone is round about +z; half_angle [rad] of the cone in
    there; blend, 0 to 1: the part of the cone's depth, 1 - cos half_angle, over which its edge fades.
    """

    frame: np.ndarray = field(default_factory=lambda: np.diag([1.0, -1.0, -1.0]))
    half_angle: float = np.pi / 8
    blend: float = 0.0

    def __post_init__(self):
        super().__post_init__()
        if np.shape(self.frame) != (3, 3):
            raise ValueError(f"frame must have shape (3, 3), got {np.shape(self.frame)}")
        if not 0 < self.half_angle <= np.pi / 2:
            raise ValueError(f"half_angle must lie in (0, pi/2], got {self.half_angle}")


@dataclass(frozen=True)
class Area(Point):
    """A flat lamp of even radiance round its position, which shines to one side; intensity is that of all of it, along
    its axis, `half_axes[0] x half_axes[1]`.

    half_axes (2,3) [m]: from its middle to the middles of two sides of a rectangle, or, where it is `round`, to two
    ends of an ellipse; spread [rad], full angle, of what it sends out: pi for all, and less is cut as by a grid of
    slats before it, see `sources.falloff`.
    """

    half_axes: np.ndarray = field(default_factory=lambda: np.array([[0.5, 0.0, 0.0], [0.0, -0.5, 0.0]]))
    round: bool = False
    spread: float = np.pi

    def __post_init__(self):
        super().__post_init__()
        if np.shape(self.half_axes) != (2, 3):
            raise ValueError(f"half_axes must have shape (2, 3), got {np.shape(self.half_axes)}")
        if not 0 < self.spread <= np.pi:
            raise ValueError(f"spread must lie in (0, pi], got {self.spread}")


@dataclass(frozen=True)
class Piece(Spot):
    """A piece of an Area, which shines from its middle: what is named after it stands for `lamp`, `among` pieces of
    equal power.

    half_axes (2,3) [m] of the ellipse with the second moments of the piece, which is one if it is `round`, else a
    rectangle; its frame's rows are unit, half_angle is half the lamp's spread.
    """

    lamp: str = ""
    among: int = 1
    half_axes: np.ndarray = field(default_factory=lambda: np.zeros((2, 3)))
    round: bool = True


@dataclass(frozen=True)
class Scene:
    """All that one frame needs. Receivers block light too; the water blocks none. lights: Sun, Point, Spot or Area,
    above the water; eta and sigma_a (3,) [1/m], refraction and absorption of what is below it. A scene without water
    has one without triangles. casters: what else throws caustics; volume: what bounds their work, None for their own
    bounds."""

    water: Water
    receivers: tuple[Receiver, ...]
    occluders: tuple[Occluder, ...]
    lights: tuple[Sun | Point, ...]
    eta: float = WATER_IOR
    sigma_a: np.ndarray = field(default_factory=lambda: np.zeros(3))
    casters: tuple[Caster, ...] = ()
    volume: Volume | None = None

    def __post_init__(self):
        if np.shape(self.sigma_a) != (3,) or not (np.asarray(self.sigma_a) >= 0).all():
            raise ValueError(f"sigma_a must be three absorption coefficients >= 0, got {self.sigma_a}")


SURFACES = ("auto", "mesh")


@dataclass(frozen=True)
class Settings:
    """method: a key of `methods.METHODS`, or "auto"; tolerance: mean squared error over the mean square of
    the light that is good enough;
    resolution: texels along each side of a lightmap; padding: texels that a chart is grown by; points: photons as
    points in place of beams, with the seed of their strata, as an independent check; first_root: the walk stops at the
    first path to a texel's centre, as its source does; surface: "auto" for the smooth water that a smooth-shaded mesh
    samples, "mesh" for the mesh as it is; dispersion: the Abbe number of the water and of glass that has none of its
    own, 0 for one index for all colours, see `dispersion.py`; match_cycles: divide the images by eta^2, as Cycles shows
    what lies under water; bounces: at how many surfaces light is bent or mirrored, at most, on its way over casters;
    reuse: what share of its light a texel keeps from frame to frame, see `reuse.py`; without: names of the physical
    terms to leave out, see `terms.py`; iterations and grid: of `caustic_map`, how often a landing point is looked up
    again, and points along the water in the light's view, 0 for as many as the tolerance asks for; tile: water and
    receiver are one tile of a pool without an end, see `tile/tile.py`."""

    method: str = "auto"
    tolerance: float = 0.01
    resolution: int = 512
    padding: int = 4
    points: bool = False
    seed: int = 0
    first_root: bool = False
    surface: str = "auto"
    dispersion: float = 0.0
    match_cycles: bool = False
    bounces: int = 6
    reuse: float = 0.0
    without: tuple[str, ...] = ()
    iterations: int = 2
    grid: int = 0
    tile: bool = False


@dataclass
class Diagnostics:
    """What a solver says of its work; the same for every method, and what bake.json holds.

    seconds: stage -> s. flux_in (3,) [W] on the water's lit side; flux_received: receiver -> (3,) [W]; flux_lost:
    cause -> (3,) [W]. texels: status -> count. paths: outcome -> count. estimated_error: mean squared error over the
    mean square of the light, None where the method has no estimate. left_out: sentences on what the result does not
    contain. surface: a sentence on the surface that the light met, the mesh's or a smoother one. etas (3,): the indices
    that bent red, green and blue; map_scale (3,): what the images are the irradiance times of, all else here is in
    watts. slow_rays: why rays were traced without embreex, empty where it served. plan: what the planner chose, and by
    which numbers, see `plan/words.py`; empty where it was not asked.
    """

    method: str
    reason: str
    seconds: dict[str, float] = field(default_factory=dict)
    flux_in: np.ndarray = field(default_factory=lambda: np.zeros(3))
    flux_received: dict[str, np.ndarray] = field(default_factory=dict)
    flux_lost: dict[str, np.ndarray] = field(default_factory=dict)
    texels: dict[str, int] = field(default_factory=dict)
    paths: dict[str, int] = field(default_factory=dict)
    estimated_error: float | None = None
    left_out: list[str] = field(default_factory=list)
    surface: str = ""
    etas: np.ndarray = field(default_factory=lambda: np.full(3, WATER_IOR))
    map_scale: np.ndarray = field(default_factory=lambda: np.ones(3))
    slow_rays: str = ""
    plan: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Solution:
    """images: per receiver (H,W,3) float64 irradiance [W/m^2], row 0 at v = 0, padded past chart borders: what goes
    through the water or off it, and nothing that comes straight from a light; status: per receiver (H,W) uint8, see
    `status.py`; diagnostics."""

    images: tuple[np.ndarray, ...]
    status: tuple[np.ndarray, ...]
    diagnostics: Diagnostics

    @cached_property
    def power(self):
        """Mean square of the light over its squared mean; 1 without light."""
        total, squares, count = 0.0, 0.0, 0
        for image, status in zip(self.images, self.status, strict=True):
            light = (image[..., 0] + image[..., 1] + image[..., 2])[status != Status.EMPTY]
            total, squares, count = total + light.sum(), squares + light @ light, count + len(light)
        return float(squares * count / total**2) if total > 0 else 1.0

    def told(self, diagnostics):
        """The same light with other Diagnostics."""
        other = replace(self, diagnostics=diagnostics)
        other.__dict__["power"] = self.power  # the cached one
        return other
