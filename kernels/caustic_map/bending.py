"""What the light's view sees of water, glass and metal, bent: the points and directions that leave, with their flux.

The flux of a cell of the view is what falls into it: [1]'s weight (N.L) / V of each vertex is the share of a surface's
area, and the cells of the light's own view have it in their number. Fresnel's shares are on top.

Glass bends light twice, in the light's view [2]: at P1 into T1, and at P2 = P1 + d T1 out again by the normal that the
view of the back faces has there, with d = w d_V + (1 - w) d_N, w = theta_t / theta_i, of the thickness d_V along the
light and d_N along the normal.

[1] Shah, Konttinen & Pattanaik 2007, Caustics Mapping: III.B, III.E.
[2] Wyman 2005, An Approximate Image-Space Approach for Interactive Refraction, section 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..casters import Glass
from ..optics import dot
from ..rays import MISS
from ..trace.interface import fresnel, reflected, refracted, schlick

_TINY = np.finfo(float).tiny


@dataclass
class Bent:
    """Light that leaves surfaces: at v (3,n) along r (3,n), flux (C,n) of each per unit of the light's power, area (n,)
    [m^2] across r; away (n,) [m] from the light, or inf; sigma_a (3,) [1/m] of what it goes through next; mirrored:
    back to where it came from; nearer: by how much the way along r to a plane is shorter than straight on, where there
    is one that is likely."""

    v: np.ndarray
    r: np.ndarray
    flux: np.ndarray
    area: np.ndarray
    away: np.ndarray
    sigma_a: np.ndarray
    mirrored: bool
    nearer: np.ndarray | float = 1.0


class Seen:
    """What a View sees of a Shaded soup in the cells of a Raster: triangle, point, facet and normal of each cell's
    (n,), towards and away, the way to the light, flux (n,) and area (n,) across the light."""

    def __init__(self, view, shaded, raster):
        uv = raster.centres
        origin, direction = view.rays(uv)
        triangle = shaded.first(origin, direction)
        hit = np.flatnonzero(triangle != MISS)
        self.triangle, self.direction, uv = triangle[hit], direction[:, hit], uv[:, hit]
        self.point, self.facet, self.normal = shaded.meet(self.triangle, origin[:, hit], self.direction)
        self.towards, self.away = view.towards(self.point)
        self.flux = raster.cell**2 * view.density(uv)
        self.area = np.full(len(hit), raster.cell**2)
        if not view.parallel:
            self.area = self.area * (1 + (uv * uv).sum(0)) ** -1.5 * self.away**2

    def take(self, index):
        other = object.__new__(Seen)
        for name, value in vars(self).items():
            other.__dict__[name] = value if np.isscalar(value) else value[..., index]
        return other


def from_water(seen, eta, sigma_a):
    """The Bent light that passes the water, and what it mirrors."""
    cos_i = np.maximum(dot(seen.normal, seen.towards), 0.0)
    cos_t, turned = fresnel(cos_i, 1 / eta)
    lit = cos_i > 0
    through = refracted(seen.direction, seen.normal, cos_i, cos_t, 1 / eta)
    wider = cos_t / np.maximum(cos_i, _TINY)
    passed = np.where(lit, seen.flux * (1 - turned), 0.0)
    yield Bent(seen.point, through, passed[None], seen.area * wider, seen.away, sigma_a, False, cos_i / cos_t)
    back = reflected(seen.direction, seen.normal, cos_i)
    yield Bent(seen.point, back, np.where(lit, seen.flux * turned, 0.0)[None], seen.area, seen.away, np.zeros(3), True)


def from_casters(seen, shaded, casters, backs):
    """The Bent light that casters mirror, and that glass among them passes by two surfaces; backs: `Backs`."""
    cos_i = np.clip(dot(seen.normal, seen.towards), 0.0, 1.0)
    turned, glassy = np.zeros((3, len(cos_i))), np.zeros(len(cos_i), bool)
    eta, sigma_a, clear = np.ones(len(cos_i)), np.zeros((3, len(cos_i))), np.ones((3, len(cos_i)))
    for k, caster in enumerate(casters):
        own, material = np.flatnonzero(shaded.mesh[seen.triangle] == k), caster.material
        if isinstance(material, Glass):
            glassy[own] = dot(seen.facet[:, own], seen.towards[:, own]) > 0
            eta[own], sigma_a[:, own] = material.eta, np.asarray(material.sigma_a)[:, None]
            clear[:, own] = np.asarray(material.transmits)[:, None]
            turned[:, own] = np.asarray(material.reflects)[:, None] * fresnel(cos_i[own], 1 / material.eta)[1]
        else:
            f0, f90 = (np.asarray(f, float)[:, None] for f in (material.f0, material.f90))
            turned[:, own] = schlick(cos_i[own], f0, f90)
    lit = cos_i > 0
    back = reflected(seen.direction, seen.normal, cos_i)
    yield Bent(seen.point, back, np.where(lit, seen.flux * turned, 0.0), seen.area, seen.away, np.zeros(3), True)
    own = np.flatnonzero(glassy & lit)
    if len(own):
        yield _twice(seen.take(own), shaded, eta[own], sigma_a[:, own], clear[:, own], backs)


def _twice(seen, shaded, eta, sigma_a, clear, backs):
    """The Bent light that passes glass of indices eta (n,) by its front and its back."""
    cos_i = np.clip(dot(seen.normal, seen.towards), 0.0, 1.0)
    cos_t, turned = fresnel(cos_i, 1 / eta)
    inner = refracted(seen.direction, seen.normal, cos_i, cos_t, 1 / eta)
    depth = _thickness(seen, shaded, cos_i, cos_t, backs)
    leaves = seen.point + depth * inner
    normal, known = backs.normal(leaves)
    cos_b = np.clip(dot(normal, inner), 0.0, 1.0)
    cos_o, kept = fresnel(cos_b, eta)
    outer = refracted(inner, -normal, cos_b, cos_o, eta)
    share = np.where(known & (cos_b > 0), (1 - turned) * (1 - kept), 0.0)
    flux = seen.flux * share * clear**2 * np.exp(-sigma_a * depth)
    wider = cos_t / np.maximum(cos_i, _TINY) * cos_o / np.maximum(cos_b, _TINY)
    outer = np.where(share > 0, outer / np.maximum(np.sqrt(dot(outer, outer)), _TINY), seen.direction)
    return Bent(leaves, outer, flux, seen.area * wider, seen.away, np.zeros(3), False)


def _thickness(seen, shaded, cos_i, cos_t, backs):
    """How far (n,) the bent light goes in the glass, as [2] has it."""
    straight = backs.distance(seen.point)
    inward = -seen.normal
    start = seen.point + shaded.off * inward
    across = shaded.first(start, inward)
    hit = across != MISS
    along = straight.copy()
    met = shaded.meet(across[hit], start[:, hit], inward[:, hit])[0]
    along[hit] = np.sqrt(((met - seen.point[:, hit]) ** 2).sum(0))
    theta_i, theta_t = np.arccos(np.clip(cos_i, -1, 1)), np.arccos(np.clip(cos_t, -1, 1))
    weight = np.where(theta_i > 1e-6, theta_t / np.maximum(theta_i, 1e-6), 1.0)
    return weight * straight + (1 - weight) * along


class Backs:
    """The back faces of a Shaded soup, the farthest ones, in a View: a map of their points and normals."""

    def __init__(self, view, shaded, raster):
        self._view, self._raster = view, raster
        origin, direction = view.from_behind(raster.centres)
        triangle = shaded.first(origin, direction)
        self._hit = triangle != MISS
        self._mesh = np.where(self._hit, shaded.mesh[np.maximum(triangle, 0)], MISS)
        self._values = np.zeros((6, len(triangle)))
        at = np.flatnonzero(self._hit)
        point, _, normal = shaded.meet(triangle[at], origin[:, at], direction[:, at])
        self._values[:, at] = np.concatenate([point, normal])

    def normal(self, p):
        """Unit normals (3,n), outwards, seen at points p (3,n), and whether (n,) there is one."""
        values, known = self._look_up(p)
        length = np.sqrt(dot(values[3:], values[3:]))
        return values[3:] / np.maximum(length, _TINY), known & (length > 0)

    def distance(self, p):
        """Distances (n,) from points p (3,n) to what is seen behind them."""
        values, known = self._look_up(p)
        return np.where(known, np.sqrt(((values[:3] - p) ** 2).sum(0)), 0.0)

    def _look_up(self, p):
        own, _, around, share = self._raster.look_up(self._view.project(p))
        known = (own >= 0) & self._hit[own]
        one = (self._mesh[around] == self._mesh[own]).all(0) & known
        values = self._values[:, own]
        at = np.flatnonzero(one)
        values[:, at] = sum(s[at] * self._values[:, a[at]] for s, a in zip(share, around, strict=True))
        return values, known
