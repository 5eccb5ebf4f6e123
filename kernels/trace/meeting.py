"""Rays that meet surfaces which bend or mirror them: what leaves, both branches or the one that a code asks for."""

from __future__ import annotations

import numpy as np

from ..optics import dot
from .interface import fresnel, reflected, refracted, schlick

_MIX = 0x1E3779B97F4A7C15  # odd: its products spread over all bits
_GRAZING = 1e-9  # cosine of incidence, at least
_LEAST = 1e-4  # cosine at which light leaves a facet, at least, though its normal sends it to the other side


class Meeting:
    """Rays `at` (k,) of Rays where they meet bending triangles (k,) of Surfaces."""

    def __init__(self, surfaces, rays, at, triangle):
        self._surfaces, self._rays, self._at, self._triangle = surfaces, rays, at, triangle
        self._direction, mask = np.take(rays.direction, at, axis=1), np.take(rays.mask, at)
        self._point, self._distance, facet, fall = surfaces.point(
            np.take(rays.origin, at, axis=1), self._direction, triangle
        )
        enters = fall < 0
        self._material = np.take(surfaces.material, triangle - surfaces.solid)
        unit, media = np.take(surfaces.unit, self._material), surfaces.media
        self._turned_mask, self._passed_mask, self._wrong = media.crossed(mask, unit, enters)
        self._before, after = media.filling(self._turned_mask), media.filling(self._passed_mask)
        self._mirror = unit == 0
        self._straight = (self._before == after) & ~self._mirror
        self._ratio = np.take(surfaces.eta, self._before) / np.take(surfaces.eta, after)
        against = np.where(enters, 1.0, -1.0)
        self._facet, self._normal = facet * against, surfaces.normal(triangle, self._point) * against
        # Where a facet is seen whose normal looks away, light grazes what the mesh samples: all of it goes straight on.
        self._cos_i = np.clip(-dot(self._normal, self._direction), _GRAZING, 1)

    def leave(self, codes=None):
        """The Rays that leave; of Codes, those that are still on their way to one that they ask for."""
        code = np.take(self._rays.code, self._at)
        passes, turns, choice = ~self._mirror, ~self._straight, ~self._mirror & ~self._straight
        if codes is not None:
            want = np.take(self._rays.want, self._at)
            passes &= ~choice | codes.leads(1, code, want)
            turns &= ~choice | codes.leads(0, code, want)
        passed, turned = np.flatnonzero(passes), np.flatnonzero(turns)
        both = np.concatenate([passed, turned])
        cos_t, share = fresnel(self._cos_i, self._ratio)
        parts = self._passed(passed, cos_t, share, code, codes), self._turned(turned, share, code, codes)
        joined = (np.concatenate(pair, axis=-1) for pair in zip(*parts, strict=True))
        return self._gone(both, *joined)

    def _passed(self, at, cos_t, share, code, codes):
        """Of what passes of those `at`: directions, where they start, shares over those before, tints, masks, codes."""
        surfaces, straight = self._surfaces, np.take(self._straight, at)
        normal, direction, facet = (np.take(v, at, axis=1) for v in (self._normal, self._direction, self._facet))
        cos_i, cos_t, ratio, share, code = (np.take(v, at) for v in (self._cos_i, cos_t, self._ratio, share, code))
        bent = _on_its_side(refracted(direction, normal, cos_i, cos_t, ratio), -facet)
        tint, after = np.take(surfaces.transmits, np.take(self._material, at), axis=1), _next(codes, 1, code)
        share = 1 - share
        if straight.any():
            bent, tint = np.where(straight, direction, bent), np.where(straight, 1.0, tint)
            share, after = np.where(straight, 1.0, share), np.where(straight, code, after)
        start = np.take(self._point, at, axis=1) - surfaces.off * facet
        return bent, start, share, tint, np.take(self._passed_mask, at), after

    def _turned(self, at, share, code, codes):
        """As `_passed`, of what interfaces turn back and mirrors reflect."""
        surfaces, mirror, material = self._surfaces, np.take(self._mirror, at), np.take(self._material, at)
        normal, direction, facet = (np.take(v, at, axis=1) for v in (self._normal, self._direction, self._facet))
        cos_i, share, code = (np.take(v, at) for v in (self._cos_i, share, code))
        tint, after = np.take(surfaces.reflects, material, axis=1), _next(codes, 0, code)
        if mirror.any():
            f0, f90 = (np.take(v, material, axis=1) for v in (surfaces.f0, surfaces.f90))
            tint = np.where(mirror, schlick(cos_i, f0, f90), tint)
            share, after = np.where(mirror, 1.0, share), np.where(mirror, code, after)
        start = np.take(self._point, at, axis=1) + surfaces.off * facet
        direction = _on_its_side(reflected(direction, normal, cos_i), facet)
        return direction, start, share, tint, np.take(self._turned_mask, at), after

    def _gone(self, both, direction, start, share, tint, mask, code):
        """The Rays that leave, of those `both` (k,) that meet, with what changes on the way."""
        rays, surfaces = self._rays, self._surfaces
        old, triangle, counts = (np.take(v, both) for v in (self._at, self._triangle, ~self._straight))
        distance = np.take(self._distance, both)
        path = np.take(rays.path, old)
        met_patch = (path + np.take(surfaces.patch, triangle - surfaces.solid) + 1) * _MIX
        colour = surfaces.dimmed(np.take(rays.colour, old, axis=1), np.take(self._before, both), distance)
        return type(rays)(
            photon=np.take(rays.photon, old),
            origin=np.take(self._point, both, axis=1),
            direction=direction,
            start=start,
            share=np.take(rays.share, old) * share,
            colour=colour * tint,
            mask=mask,
            code=code,
            want=np.take(rays.want, old),
            path=np.where(counts, met_patch, path),
            met=np.take(rays.met, old) + counts,
            cast=np.take(rays.cast, old) | (triangle < surfaces.water),
            out=np.take(rays.out, old),
            way=np.take(rays.way, old) + distance,
            astray=np.where(np.take(self._wrong, both), triangle + 1, np.take(rays.astray, old)),
        )


def _next(codes, turn, code):
    """Codes (k,), or nodes of Codes, after a choice."""
    return 2 * code + turn if codes is None else np.take(codes.step[turn], code)


def _on_its_side(direction, facet):
    """Unit directions (3,k), those that do not leave facets (3,k) on their side brought to graze them there."""
    along = dot(direction, facet)
    low = np.flatnonzero(along < _LEAST)
    if len(low):
        d = direction[:, low] + (_LEAST - along[low]) * facet[:, low]
        direction[:, low] = d / np.sqrt(dot(d, d))
    return direction
