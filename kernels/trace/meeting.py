"""Rays that meet surfaces which bend or mirror them: what leaves, both branches or the one that a code asks for."""

from __future__ import annotations

import numpy as np

from ..optics import dot
from .crossings import CHOICE, MIRROR, STRAIGHT
from .interface import fresnel, reflected, refracted, schlick
from .picks import chosen, indices, joined, pick, some, within

_MIX = 0x1E3779B97F4A7C15  # odd: its products spread over all bits
_GRAZING = 1e-9  # cosine of incidence, at least
_LEAST = 1e-4  # cosine at which light leaves a facet, at least, though its normal sends it to the other side


class Meeting:
    """Rays `at`, see `picks`, of Rays where they meet bending triangles (k,) of Surfaces."""

    def __init__(self, surfaces, rays, at, triangle):
        self._surfaces, self._rays, self._at, self._count = surfaces, rays, at, len(triangle)
        self._triangle = triangle.astype(np.int64) - surfaces.solid
        self._direction = pick(rays.direction, at)
        met = surfaces.met(pick(rays.origin, at), self._direction, self._triangle)
        self._point, self._distance, self._facet, normal, fall = met
        enters = fall < 0
        self._side = 1.0 - 2.0 * ~enters  # of the facet, to which light comes
        self._twice = surfaces.twice.take(self._triangle)
        self._key = surfaces.crossings.key(pick(rays.state, at), self._twice, enters)
        self._kind = surfaces.crossings.kind.take(self._key)
        self._odd = self._kind.any()  # else light may go both ways everywhere
        # Where a facet is seen whose normal looks away, light grazes what the mesh samples: all of it goes straight on.
        self._normal = normal
        self._cos_i = dot(normal, self._direction)
        self._cos_i *= -self._side
        np.maximum(self._cos_i, _GRAZING, out=self._cos_i)

    def leave(self, codes=None):
        """The Rays that leave; of Codes, those that are still on their way to one that they ask for."""
        code = pick(self._rays.code, self._at)
        self._ratio = self._surfaces.crossings.ratio.take(self._key)
        cos_t, share = fresnel(self._cos_i, self._ratio)
        passed, turned = self._branches(code, codes, cos_t)
        parts = self._passed(passed, cos_t, share, code, codes), self._turned(turned, share, code, codes)
        if not some(turned):
            return self._gone(passed, *parts[0])
        if not some(passed):
            return self._gone(turned, *parts[1])
        both = [indices(part, self._count) for part in (passed, turned)]
        counts = [len(part) for part in both]
        together = (None if a is None else joined(a, b, counts) for a, b in zip(*parts, strict=True))
        return self._gone(np.concatenate(both), *together)

    def _branches(self, code, codes, cos_t):
        """Which of them pass, and which are turned back; where none is refracted, nothing passes."""
        passes, turns = cos_t > 0, np.ones(self._count, bool)
        if codes is not None:
            want = pick(self._rays.want, self._at)
            passes &= codes.leads(1, code, want)
            turns &= codes.leads(0, code, want)
        if self._odd:
            passes = np.where(self._kind == CHOICE, passes, self._kind == STRAIGHT)
            turns = np.where(self._kind == CHOICE, turns, self._kind == MIRROR)
        return chosen(passes), chosen(turns)

    def _passed(self, at, cos_t, share, code, codes):
        """Of what passes of those `at`: directions, where they start, shares over those before, tints, states, codes,
        what they left; None for tints where they change nothing, and for what is left where nothing is told by it."""
        surfaces = self._surfaces
        normal, direction, facet, point = (
            pick(v, at) for v in (self._normal, self._direction, self._facet, self._point)
        )
        cos_i, cos_t, ratio, share, code, side = (
            pick(v, at) for v in (self._cos_i, cos_t, self._ratio, share, code, self._side)
        )
        bent, along = _on_its_side(refracted(direction, normal, cos_i, cos_t, ratio, side), facet, -side)
        tint, after = self._tint(surfaces.transmits, at), _next(codes, 1, code)
        share = 1 - share
        if self._odd:
            straight = pick(self._kind, at) == STRAIGHT
            bent, tint = np.where(straight, direction, bent), np.where(straight, 1.0, tint)
            share, after = np.where(straight, 1.0, share), np.where(straight, code, after)
            along = np.where(straight, -side * dot(direction, facet), along)
        start = point - (surfaces.off * side) * facet
        state = surfaces.crossings.passed.take(pick(self._key, at))
        return bent, start, share, tint, state, after, self._left(at, side < 0, along)

    def _turned(self, at, share, code, codes):
        """As `_passed`, of what interfaces turn back and mirrors reflect."""
        surfaces = self._surfaces
        normal, direction, facet, point = (
            pick(v, at) for v in (self._normal, self._direction, self._facet, self._point)
        )
        cos_i, share, code, side = (pick(v, at) for v in (self._cos_i, share, code, self._side))
        tint, after = self._tint(surfaces.reflects, at), _next(codes, 0, code)
        if self._odd:
            mirror, material = pick(self._kind, at) == MIRROR, pick(self._twice, at) // 2
            f0, f90 = (v.take(material, axis=1) for v in (surfaces.f0, surfaces.f90))
            tint = np.where(mirror, schlick(cos_i, f0, f90), tint)
            share, after = np.where(mirror, 1.0, share), np.where(mirror, code, after)
        start = point + (surfaces.off * side) * facet
        direction, along = _on_its_side(reflected(direction, normal, cos_i, side), facet, side)
        state = surfaces.crossings.turned.take(pick(self._key, at))
        return direction, start, share, tint, state, after, self._left(at, side > 0, along)

    def _left(self, at, outwards, along):
        """What those `at` are marked with that leave outwards (k,) bool, at cosines along (k,) to facets; see
        `legs.Legs`."""
        legs = self._surfaces.legs
        if not legs.known:
            return None
        triangle = pick(self._triangle, at)
        left = legs.left.take(2 * triangle + outwards)
        if legs.dented:
            left *= along > legs.steep.take(triangle)
        return left

    def _tint(self, colours, at):
        """Of colours (C,materials) those (C,k) of the materials of those `at`, or None where nothing has one."""
        if not (self._surfaces.tinted or self._odd):
            return None
        return colours.take(pick(self._twice, at) // 2, axis=1)

    def _gone(self, both, direction, start, share, tint, state, code, left):
        """The Rays that leave, of those `both` that meet, with what changes on the way."""
        rays, surfaces, old = self._rays, self._surfaces, within(self._at, both, len(self._rays.photon))
        triangle, key = pick(self._triangle, both), pick(self._key, both)
        distance, path = pick(self._distance, both), pick(rays.path, old)
        met_patch = path + surfaces.patch.take(triangle)
        met_patch += 1
        met_patch *= _MIX
        counts = True
        if self._odd:
            counts = pick(self._kind, both) != STRAIGHT
            met_patch = np.where(counts, met_patch, path)
        colour = pick(rays.colour, old)
        if surfaces.absorbing:
            colour = surfaces.dimmed(colour, surfaces.crossings.before.take(key), distance)
        wrong, astray = surfaces.crossings.wrong.take(key), pick(rays.astray, old)
        if wrong.any():
            astray = np.where(wrong, triangle + surfaces.solid + 1, astray)
        return type(rays)(
            photon=pick(rays.photon, old),
            origin=pick(self._point, both),
            direction=direction,
            start=start,
            share=pick(rays.share, old) * share,
            colour=colour if tint is None else colour * tint,
            state=state,
            code=code,
            want=pick(rays.want, old),
            path=met_patch,
            met=pick(rays.met, old) + counts,
            cast=pick(rays.cast, old) | (True if surfaces.dry else triangle < surfaces.water - surfaces.solid),
            out=pick(rays.out, old),
            way=pick(rays.way, old) + distance,
            astray=astray,
            left=pick(rays.left, old) if left is None else left,
        )


def _next(codes, turn, code):
    """Codes (k,), or nodes of Codes, after a choice."""
    return 2 * code + turn if codes is None else np.take(codes.step[turn], code)


def _on_its_side(direction, facet, side):
    """Unit directions (3,k), those that do not leave facets (3,k) on one side, 1 or -1 (k,), brought to graze them
    there; and the cosines (k,) at which they had left."""
    along = side * dot(direction, facet)
    if along.min(initial=1.0) < _LEAST:
        low = np.flatnonzero(along < _LEAST)
        d = direction[:, low] + (_LEAST - along[low]) * (side[low] * facet[:, low])
        direction[:, low] = d / np.sqrt(dot(d, d))
    return direction, along
