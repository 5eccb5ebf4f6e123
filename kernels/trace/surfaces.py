"""All that a ray can meet, as tables per triangle: what ends it, and the smooth surfaces that bend or mirror it.

Triangles are numbered through receivers, occluders, casters and the water, in this order.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..casters import Glass
from ..facets import used
from ..maps.charts import patches
from ..optics import dot
from ..rays import Tracer, soup
from .crossings import Crossings
from .legs import Legs
from .media import Media, outside
from .receded import receded
from .steady import bounds

_OFF = 2e-6  # of the extent: how far off a surface rays start, so that float32 does not find what they leave
_ALIKE = 1 << 18  # to the unit: normals that round to the same are one
_TINY = np.finfo(float).tiny
_APART = 1 << 32  # more patches than a mesh has: how many one has changes no number of another's


class Surfaces:
    """The Scene as rays meet it; channels (3,): the row of what a ray carries for each of red, green and blue.

    receiving, solid: how many triangles belong to receivers, and to all that ends rays; water: from which one on they
    are water. media: the Media, and crossings: the Crossings; sigma_a (C,media), and absorbing: whether any does; twice
    (T,) the material of bending triangles, and of materials, which differ also by the class of media that they bound:
    reflects, transmits, f0, f90 (C,materials); tinted: whether any interface is; dry: whether there is no
    water; legs: the Legs.
    """

    def __init__(self, scene, power):
        if len(scene.water.triangles):
            scene = replace(scene, water=replace(scene.water, normals=outside(scene.water)))
        self.media = Media(scene)
        meshes = (*scene.casters, scene.water)
        self.receiving = sum(len(r.triangles) for r in scene.receivers)
        self.solid = self.receiving + sum(len(o.triangles) for o in scene.occluders)
        corners = used(*soup((*scene.receivers, *meshes)))  # what only blocks may be miles away
        about = np.array(bounds(corners.min(0), corners.max(0)) if len(corners) else np.zeros((2, 3)))
        self.off = _OFF * np.linalg.norm(about[1] - about[0])
        solid = (*receded(scene, self.off), *scene.occluders)
        self.meshes = (*solid, *meshes)
        self.tracer = Tracer(*soup(self.meshes), about)
        self.water = self.solid + sum(len(c.triangles) for c in scene.casters)
        self._tabulate_materials(scene, np.asarray(power, float))
        soups = [s.positions[s.triangles] for s in (*scene.receivers, *scene.occluders)]
        self._solids = np.concatenate([np.zeros((4, 0)), *(_planes(soup) for soup in soups)], 1)
        self._casters, self.dry = scene.casters, not len(scene.water.triangles)
        tables = [_geometry(mesh) for mesh in meshes]
        self._table = np.concatenate(tables, 1)
        self.patch = _patches(meshes)
        self.legs = Legs((*solid, *meshes), self.tracer, len(solid), self._table[:3])

    def _tabulate_materials(self, scene, power):
        """Materials: one for each different one of the casters, in each class of media that it bounds, and the
        water."""
        sizes = [*(len(c.triangles) for c in scene.casters), len(scene.water.triangles)]
        found = [*(c.material for c in scene.casters), Glass(scene.eta, scene.sigma_a)]
        keys = list(zip(map(_key, found), self.media.classes.tolist(), strict=True))
        unique = dict(zip(keys, found, strict=True))
        numbers = {key: k for k, key in enumerate(unique)}
        self.twice = np.repeat([2 * numbers[key] for key in keys], sizes)
        self.crossings = Crossings(self.media, self.media.units(np.array([k for _, k in unique])))
        materials = list(unique.values())
        colours = [
            self.media.sigma_a,
            *(np.stack([_colour(m, name) for m in materials]) for name in ("reflects", "transmits", "f0", "f90")),
        ]
        dark = np.flatnonzero(power <= 0)
        stacked = np.concatenate(colours)
        stacked[:, dark] = stacked[:, [int(np.argmax(power))]]  # a dark channel needs no row
        rows, self.channels = np.unique(stacked, axis=1, return_inverse=True)
        self.channels = self.channels.reshape(-1)
        cuts = np.cumsum([len(c) for c in colours])[:-1]
        self.sigma_a, self.reflects, self.transmits, self.f0, self.f90 = (p.T for p in np.split(rows, cuts))
        self.absorbing = bool(self.sigma_a.any())
        self.tinted = bool((self.reflects != 1).any() or (self.transmits != 1).any())

    def lie_in(self, box):
        """Whether all that bends light but water lies in a convex `volume.Box`, and there is no water."""
        return self.dry and all(box.contains(mesh.positions.T).all() for mesh in self._casters)

    def first(self, rays):
        """The first triangle (k,) that Rays meet, MISS for none."""
        return self.legs.first(rays.start, rays.direction, rays.left)

    def hits(self, rays):
        """As `first`; how far (k,) it is to there; and whether (k,) it may be another one, see `rays.Tracer.hits`."""
        return self.legs.hits(rays.start, rays.direction, rays.left)

    def met(self, origin, direction, triangle):
        """Where rays from origins along directions (3,k) meet bending triangles (k,), numbered from 0: points (3,k),
        distances (k,), facets' unit normals (3,k) out of what they enclose, the shading's, and the products (k,) of the
        first with the directions."""
        rows = self._table.take(triangle, 1, mode="clip")
        facet = rows[:3]
        fall = dot(facet, direction)
        distance = dot(facet, origin)
        distance += rows[3]
        with np.errstate(divide="ignore", invalid="ignore"):
            distance /= -fall
        np.maximum(distance, 0, out=distance)
        distance[~np.isfinite(distance)] = 0.0  # a facet exactly along the ray
        point = distance * direction
        point += origin
        normal = rows[7::4]
        for k, row in enumerate(_ROWS):
            normal[k] += dot(rows[row : row + 3], point)
        normal /= np.sqrt(np.maximum(dot(normal, normal), _TINY))
        return point, distance, facet, normal, fall

    def distance(self, origin, direction, end):
        """How far (k,) rays from origins along directions (3,k) go to the triangles that they meet, `end` (k,); inf
        where they meet none."""
        bends = end >= self.solid
        plane = np.empty((4, len(end)))
        plane[:, bends] = np.take(self._table[:4], end[bends] - self.solid, axis=1)
        plane[:, ~bends] = np.take(self._solids, np.maximum(end[~bends], 0), axis=1) if self.solid else 0.0
        fall = dot(plane, direction)
        distance = -(dot(plane, origin) + plane[3]) / np.where(fall == 0, np.inf, fall)
        return np.where(end < 0, np.inf, distance)

    def dimmed(self, colour, medium, distance):
        """What is left of colour (C,k) after distance (k,) [m] in media (k,)."""
        if not self.absorbing:
            return colour
        return colour * np.exp(-np.take(self.sigma_a, medium, axis=1) * distance)


_ROWS = 4, 8, 12  # of the table, where those of the normal's map start


def _key(material):
    """What tells different materials apart."""
    return type(material).__name__, *(np.asarray(v, float).tobytes() for v in vars(material).values())


def _colour(material, name):
    return np.asarray(getattr(material, name, np.ones(3)), float)


def _geometry(mesh):
    """Rows (16,T): the plane of each triangle, turned to the side of its normals, and the affine map (3,4) from a point
    of it to the interpolated normal."""
    v = mesh.positions[mesh.triangles]
    n = mesh.normals[mesh.normal_triangles]
    e1, e2 = v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]
    across = np.cross(e1, e2)
    squared = np.maximum((across**2).sum(1), _TINY)[:, None]
    to_b, to_c = np.cross(e2, across) / squared, np.cross(across, e1) / squared
    slope = (n[:, 1] - n[:, 0])[:, :, None] * to_b[:, None] + (n[:, 2] - n[:, 0])[:, :, None] * to_c[:, None]
    offset = n[:, 0] - (slope * v[:, :1]).sum(2)
    turn = np.where((across * n.sum(1)).sum(1) < 0, -1.0, 1.0)[:, None]
    facet = across * turn / np.sqrt(squared)
    plane = np.concatenate([facet, -(facet * v[:, 0]).sum(1, keepdims=True)], 1)
    return np.concatenate([plane, np.concatenate([slope, offset[:, :, None]], 2).reshape(-1, 12)], 1).T


def _planes(soup):
    """Unit normals and minus offsets (4,T) of the planes of triangles soup (T,3,3)."""
    across = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    across /= np.sqrt(np.maximum((across**2).sum(1, keepdims=True), _TINY))
    return np.concatenate([across, -(across * soup[:, 0]).sum(1, keepdims=True)], 1).T


def _patches(meshes):
    """A number (T,) for each smooth patch of the meshes: triangles that share corners of one normal."""
    numbers = []
    for k, mesh in enumerate(meshes):
        rounded = np.rint(mesh.normals * _ALIKE).astype(np.int64) + 2 * _ALIKE
        _, normal = np.unique(
            (rounded[:, 0] * 4 * _ALIKE + rounded[:, 1]) * 4 * _ALIKE + rounded[:, 2], return_inverse=True
        )
        keys = mesh.triangles.astype(np.int64) * (len(mesh.normals) + 1) + normal.reshape(-1)[mesh.normal_triangles]
        _, corner = np.unique(keys, return_inverse=True)
        numbers.append(patches(corner.reshape(-1, 3)) + k * _APART)
    return np.concatenate(numbers)
