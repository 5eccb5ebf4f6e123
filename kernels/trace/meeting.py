"""Rays that meet surfaces which bend or mirror them: what leaves, both branches or the one that a code asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..optics import dot
from .interface import fresnel, reflected, refracted, schlick

_MIX = 0x1E3779B97F4A7C15  # odd: its products spread over all bits
_GRAZING = 1e-9  # cosine of incidence, at least
_LEAST = (
    1e-4  # cosine at which light leaves a facet, at least, though its interpolated normal sends it to the other side
)


class Meeting:
    """Rays where they meet bending triangles (k,) of Surfaces."""

    def __init__(self, surfaces, rays, triangle):
        self._surfaces = surfaces
        point, distance, facet, fall = surfaces.point(rays, triangle)
        enters = fall < 0
        self._material = np.take(surfaces.material, triangle - surfaces.solid)
        unit, media = np.take(surfaces.unit, self._material), surfaces.media
        self._turned_mask, self._passed_mask, wrong = media.crossed(rays.mask, unit, enters)
        before, after = media.filling(self._turned_mask), media.filling(self._passed_mask)
        self._mirror = unit == 0
        self._straight = (before == after) & ~self._mirror
        self._ratio = np.take(surfaces.eta, before) / np.take(surfaces.eta, after)
        against = np.where(enters, 1.0, -1.0)
        self._facet, self._normal = facet * against, surfaces.normal(triangle, point) * against
        # Where a facet is seen whose normal looks away, light grazes what the mesh samples: all of it goes straight on.
        self._cos_i = np.clip(-dot(self._normal, rays.direction), _GRAZING, 1)
        path = (rays.path + np.take(surfaces.patch, triangle - surfaces.solid) + 1) * _MIX
        self._rays = replace(
            rays,
            origin=point,
            way=rays.way + distance,
            colour=surfaces.dimmed(rays.colour, before, distance),
            cast=rays.cast | (triangle < surfaces.water),
            path=np.where(self._straight, rays.path, path),
            met=rays.met + ~self._straight,
            astray=np.where(wrong, triangle + 1, rays.astray),
        )

    def leave(self, word=None):
        """The Rays that leave; of one code, those that are still on their way to it."""
        passes, turns, choice = ~self._mirror, ~self._straight, ~self._mirror & ~self._straight
        if word is not None:
            made, length = np.frexp(self._rays.code.astype(float))[1] - 1, int(word).bit_length() - 1
            asked = (word >> np.maximum(length - 1 - made, 0)) & 1 > 0
            passes &= ~choice | (asked & (made < length))
            turns &= ~choice | (~asked & (made < length))
        cos_t, share = fresnel(self._cos_i, self._ratio)
        passed, turned = np.flatnonzero(passes), np.flatnonzero(turns)
        parts = []
        if len(passed):
            parts.append(self._passed(passed, np.take(cos_t, passed), np.take(1 - share, passed)))
        if len(turned) or not parts:
            parts.append(self._turned(turned, np.take(share, turned)))
        return parts[0] if len(parts) == 1 else parts[0].join(parts[1])

    def _passed(self, at, cos_t, share):
        """The rays `at` with the share (k,) of their light that passes, cos_t (k,) along the normal."""
        rays, surfaces, straight = self._rays.take(at), self._surfaces, np.take(self._straight, at)
        normal, cos_i, ratio = (np.take(v, at, axis=-1) for v in (self._normal, self._cos_i, self._ratio))
        bent = _on_its_side(refracted(rays.direction, normal, cos_i, cos_t, ratio), -np.take(self._facet, at, axis=1))
        tint = np.take(surfaces.transmits, np.take(self._material, at), axis=1)
        return self._gone(
            rays,
            at,
            -1,
            direction=np.where(straight, rays.direction, bent),
            share=np.where(straight, rays.share, rays.share * share),
            colour=np.where(straight, rays.colour, rays.colour * tint),
            mask=np.take(self._passed_mask, at),
            code=np.where(straight, rays.code, 2 * rays.code + 1),
        )

    def _turned(self, at, share):
        """The rays `at` with the share (k,) of their light that an interface turns back, or what a mirror does."""
        rays, surfaces, mirror = self._rays.take(at), self._surfaces, np.take(self._mirror, at)
        normal, cos_i = np.take(self._normal, at, axis=1), np.take(self._cos_i, at)
        material = np.take(self._material, at)
        tint = np.take(surfaces.reflects, material, axis=1)
        if mirror.any():
            f0, f90 = (np.take(v, material, axis=1) for v in (surfaces.f0, surfaces.f90))
            tint = np.where(mirror, schlick(cos_i, f0, f90), tint)
        return self._gone(
            rays,
            at,
            1,
            direction=_on_its_side(reflected(rays.direction, normal, cos_i), np.take(self._facet, at, axis=1)),
            share=np.where(mirror, rays.share, rays.share * share),
            colour=rays.colour * tint,
            mask=np.take(self._turned_mask, at),
            code=np.where(mirror, rays.code, 2 * rays.code),
        )

    def _gone(self, rays, at, side, **changes):
        """The rays `at` with their changes, started a little off the surface, before it (side 1) or behind it (-1)."""
        start = rays.origin + (side * self._surfaces.off) * np.take(self._facet, at, axis=1)
        return replace(rays, start=start, **changes)


def _on_its_side(direction, facet):
    """Unit directions (3,k), those that do not leave facets (3,k) on their side brought to graze them there."""
    along = dot(direction, facet)
    low = np.flatnonzero(along < _LEAST)
    if len(low):
        d = direction[:, low] + (_LEAST - along[low]) * facet[:, low]
        direction[:, low] = d / np.sqrt(dot(d, d))
    return direction
