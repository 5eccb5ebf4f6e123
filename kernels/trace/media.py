"""Which medium fills a place: air, the water, or the glass of a body that encloses it.

A body is the water or a caster of glass, its parts of several materials together. A place is in it if more of its
surfaces were come into than left on the way there, so bodies that overlap or hold cavities need no care. Where bodies
of different media overlap the smaller one fills the place, by the volume that it encloses: what is inside another
displaces it, in whatever order they come. After Schmidt & Budge 2002, Simple nested dielectrics in ray traced images,
with volumes in place of their priorities.

A ray knows how deep it is in bodies by a mask, an integer with a few bits for each class. Bodies share a class if
they are of one medium and no body of another one has to come between them; the highest class that is not 0 fills.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..casters import Glass
from ..under_water import solid_angle, under_water

_BITS = 52  # of a mask: exact as float64
_WIDE = 8  # bits for a class, at most
_OPEN, _ROUNDING = 1e-3, 1e-9  # of a surface: sums of its facets across that show a hole, and a side


@dataclass(frozen=True)
class _Body:
    """parts: the numbers of its casters, that of the water being last; medium: eta and sigma_a (3,) as a tuple of
    numbers; rank among bodies, lower for larger ones; low and high (3,), which bound it, without end if it is open."""

    parts: tuple
    medium: tuple
    rank: tuple
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of(cls, meshes, parts, medium):
        soup = _outward(meshes, parts)
        middle = soup.mean((0, 1))
        a, b, c = (soup[:, k] - middle for k in range(3))
        across = np.cross(b - a, c - a)
        if np.linalg.norm(across.sum(0)) > _OPEN * np.linalg.norm(across, axis=1).sum():
            return cls(parts, medium, (0, -np.ptp(soup, (0, 1)).max()), np.full(3, -np.inf), np.full(3, np.inf))
        volume = abs((a * np.cross(b, c)).sum())
        return cls(parts, medium, (1, -volume), soup.min((0, 1)), soup.max((0, 1)))


class Media:
    """The media of a Scene, numbered: eta (media,) and sigma_a (media,3) [1/m], of which 0 is air.

    classes (casters + 1,): of each caster, and of the water, -1 for mirrors; bounded: the bits of a mask for classes
    that light leaves again, all but that of an open water. Raises ValueError for more classes than a mask can hold.
    """

    def __init__(self, scene):
        meshes = (*scene.casters, scene.water)
        self._meshes, self._bodies = meshes, _bodies(scene, meshes)
        of_class, chosen = _classes(self._bodies)
        if len(of_class) > _BITS:
            raise ValueError(f"casters must be of at most {_BITS} different glasses, got {len(of_class)}")
        media = list(dict.fromkeys(of_class))
        self.eta = np.array([1.0, *(medium[0] for medium in media)])
        self.sigma_a = np.array([np.zeros(3), *(medium[1:] for medium in media)])
        self.classes = np.full(len(meshes), -1)
        for body, k in zip(self._bodies, chosen, strict=True):
            self.classes[list(body.parts)] = k
        self._chosen, self._count = chosen, len(of_class)
        self._width = min(_WIDE, _BITS // max(self._count, 1))
        filling = [1 + media.index(medium) for medium in of_class]
        self._fills = np.concatenate([[0], np.repeat(np.array(filling, np.int64), self._width)])
        self._most = (1 << self._width) - 1
        endless = {k for body, k in zip(self._bodies, chosen, strict=True) if self._is_water(body) and not body.rank[0]}
        self.bounded = sum(self._most << k * self._width for k in range(self._count) if k not in endless)

    def units(self, classes):
        """What (k,) a mask grows by on the way into a body of classes (k,), 0 for -1."""
        return np.where(classes < 0, 0, 1 << np.maximum(classes, 0) * self._width)

    def filling(self, mask):
        """The medium (k,) that fills the way of rays with masks (k,)."""
        return np.take(self._fills, np.frexp(mask.astype(float))[1])

    def crossed(self, mask, unit, enters):
        """Masks (k,) of rays before a surface, and behind it, of bodies of units (k,) that they enter or leave (k,);
        and whether (k,) that cannot be: they leave a body that they are not in, or come too deep into one."""
        whole = unit * self._most
        deep = mask & whole
        none, full = deep == 0, deep == whole
        inside = mask + unit * np.where(enters, ~full, none)
        before, behind = np.where(enters, mask, inside), np.where(enters, inside, inside - unit)
        return before, behind, np.where(enters, full, none) & (unit > 0)

    def at(self, point):
        """The mask of what begins at a point (3,)."""
        depth = np.zeros(self._count, np.int64)
        for body, k in zip(self._bodies, self._chosen, strict=True):
            if self._is_water(body):
                depth[k] += under_water(self._meshes[-1], point)
            elif (body.low <= point).all() and (body.high >= point).all():
                depth[k] += round(solid_angle(_outward(self._meshes, body.parts) - point).sum() / (4 * np.pi))
        return int((np.clip(depth, 0, self._most) << self._width * np.arange(len(depth))).sum())

    def _is_water(self, body):
        return body.parts == (len(self._meshes) - 1,)


def outside(water):
    """The normals (N,3) of Water, turned so that they point out of it: on the whole up, if it is open."""
    soup = _outward((water,), (0,))
    across = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
    turned = across[:, 2].sum() < -_ROUNDING * np.abs(across).sum()
    return -water.normals if turned else water.normals


def _bodies(scene, meshes):
    """Every _Body of a Scene, the larger first, and the water before all if it is open."""
    together = {}
    for k, caster in enumerate(scene.casters):
        if isinstance(caster.material, Glass) and len(caster.triangles):
            together.setdefault((caster.name, caster.positions.tobytes()), []).append(k)
    bodies = [_Body.of(meshes, tuple(parts), _medium(scene.casters, parts)) for parts in together.values()]
    bodies.sort(key=lambda body: body.rank)
    if len(scene.water.triangles):
        water = _Body.of(meshes, (len(scene.casters),), (float(scene.eta), *map(float, scene.sigma_a)))
        bodies.insert(0 if water.rank[0] == 0 else sum(b.rank <= water.rank for b in bodies), water)
    return bodies


def _medium(casters, parts):
    """That of the part of a body with the largest surface."""
    area = {}
    for k in parts:
        glass = casters[k].material
        v = casters[k].positions[casters[k].triangles]
        medium = (float(glass.eta), *map(float, glass.sigma_a))
        own = np.linalg.norm(np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0]), axis=1).sum()
        area[medium] = area.get(medium, 0.0) + own
    return max(area, key=area.get)


def _classes(bodies):
    """(medium of each class, class of each body): of a body's own medium, and above all larger bodies of other ones
    that it may overlap."""
    of_class, chosen = [], []
    low, high = (np.array([getattr(body, name) for body in bodies]).reshape(-1, 3) for name in ("low", "high"))
    number = {medium: k for k, medium in enumerate(dict.fromkeys(body.medium for body in bodies))}
    media = np.array([number[body.medium] for body in bodies], np.int64)
    for n, body in enumerate(bodies):
        near = (low[:n] <= body.high).all(1) & (high[:n] >= body.low).all(1) & (media[:n] != media[n])
        least = max((chosen[k] for k in np.flatnonzero(near)), default=-1)
        own = (k for k in range(least + 1, len(of_class)) if of_class[k] == body.medium)
        chosen.append(next(own, len(of_class)))
        if chosen[-1] == len(of_class):
            of_class.append(body.medium)
    return of_class, chosen


def _outward(meshes, parts):
    """Triangles (T,3,3) of some of the meshes, wound counter-clockwise as their normals see them."""
    soups = [np.zeros((0, 3, 3))]
    for mesh in (meshes[k] for k in parts):
        soup, leaning = mesh.positions[mesh.triangles], mesh.normals[mesh.normal_triangles].sum(1)
        across = np.cross(soup[:, 1] - soup[:, 0], soup[:, 2] - soup[:, 0])
        soups.append(np.where(((across * leaning).sum(1) < 0)[:, None, None], soup[:, ::-1], soup))
    return np.concatenate(soups)
