"""Rays followed over smooth surfaces to their ends: both branches at every interface, or those of some codes.

A code is the word of a path's choices - passes or is turned back - at the interfaces that it meets; mirrors leave no
choice. It is kept as an integer, a leading 1 and a bit for each choice, 1 for what passes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .meeting import Meeting
from .picks import ALL, chosen, pick, some, whole

_STRAIGHT = 8  # surfaces that change nothing, at most, beyond those that count
BEYOND, FAINT, CULLED, BLOCKED = -2, -3, -4, -5  # in place of a triangle, as MISS


@dataclass
class Rays:
    """k rays: photon (k,) that each is of; origin, direction (3,k), and where the cast starts, start (3,k); share (k,)
    of the photon by Fresnel alone; colour (C,k) what is left of that in each channel; state (k,) of `Crossings`;
    code (k,), or its node where Codes are asked for, and want (k,) which of them; path (k,) a number for the smooth
    patches that it met; met (k,) how many surfaces; cast (k,) bool whether one was a caster; out (k,) bool whether it
    left the volume; way (k,) [m] gone since the origin it began with; astray (k,) 1 + the last triangle at which it
    left a body that it was not in, or came too deep into one, 0 for none; left (k,) what it may meet, see
    `legs.Legs`. All but photon, origin, direction, start and colour may be one number on the way, see `picks`."""

    photon: np.ndarray
    origin: np.ndarray
    direction: np.ndarray
    start: np.ndarray
    share: np.ndarray
    colour: np.ndarray
    state: np.ndarray
    code: np.ndarray
    want: np.ndarray
    path: np.ndarray
    met: np.ndarray
    cast: np.ndarray
    out: np.ndarray
    way: np.ndarray
    astray: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, origin, direction, channels, state=0):
        """One ray a photon, in a state of `Crossings`, else in air."""
        count = direction.shape[1]
        none, no, way = (np.zeros((), kind) for kind in (np.int64, bool, float))
        shares, words = (way + 1, np.ones((channels, count))), (none + state, none + 1, none, none, none)
        left = np.zeros((), np.int16)
        return cls(np.arange(count), origin, direction, origin, *shares, *words, no, no, way, none, left)

    def take(self, index):
        """The Rays of a part, see `picks`; they do not keep the others in memory."""
        columns = vars(self).values()
        if isinstance(index, slice) and index is not ALL:
            return Rays(*(pick(a, index).copy() for a in columns))
        return self if index is ALL else Rays(*(pick(a, index) for a in columns))

    def each(self):
        """The Rays with an array for all that is one number."""
        return Rays(*(whole(a, len(self.photon)) for a in vars(self).values()))


class Follower:
    """Follows rays over Surfaces: `bounces` meetings at most; branches of no more than `faint` of a photon end; box:
    the `volume.Box` that bounds the casters, or None. cast: how many rays were cast."""

    def __init__(self, surfaces, bounces, faint=0.0, box=None):
        self.surfaces, self.bounces, self.faint, self.box = surfaces, bounces, faint, box
        self._within = box is not None and surfaces.lie_in(box)
        self.cast = 0

    def ends(self, rays, codes=None, want=None, trail=None):
        """Yield (Rays, what they end on (k,)) of rays that met a caster: a triangle of a receiver or an occluder, or
        one of MISS, BEYOND, FAINT, CULLED, BLOCKED.

        codes: follow those of these Codes that want (k,) asks for, all if it is None; what has another one ends
        untold. trail: a `trail.Trail` that is told of all rays.
        """
        if codes is not None:
            want = np.array(codes.every()) if want is None else want
            rays = replace(rays, code=np.zeros((), np.int64), want=want)
        for step in range(self.bounces + _STRAIGHT + 1):
            if not len(rays.photon):
                return
            self.cast += len(rays.photon)
            if trail is None:
                end = self.surfaces.first(rays)
            else:
                end, *where = self.surfaces.hits(rays)
                trail.add(rays, end, *where)
            final = end < self.surfaces.solid
            if self.box is not None:
                self._bound(rays, end, final)
            if step >= self.bounces:
                beyond = ~final & (rays.met >= self.bounces)
                end[beyond] = BEYOND
                final |= beyond
            yield from _told(rays, final, end, codes)
            at = chosen(~final)
            if not some(at):
                return
            rays = Meeting(self.surfaces, rays, at, end[at]).leave(codes)
            weak = rays.share * rays.colour.max(0) <= self.faint
            if weak.any():
                yield from _told(rays, weak & (rays.share > 0), np.full(len(weak), FAINT), codes)
                rays = rays.take(chosen(~weak))
        yield from _told(rays, np.ones(len(rays.photon), bool), np.full(len(rays.photon), BEYOND), codes)

    def _bound(self, rays, end, final):
        """Change what Rays end on (k,), and whether they do (k,), where they leave the box or casters lie outside.

        Between casters that all lie in the box, which is convex, no light leaves it.
        """
        caster = (end >= self.surfaces.solid) & (end < self.surfaces.water)
        at = np.flatnonzero(rays.cast & ~rays.out & ~(caster & self._within))
        if len(at) and (self.box.culling.any() or not self._within):
            origin, direction = (np.take(v, at, axis=1) for v in (rays.origin, rays.direction))
            distance, face = self.box.leaves(origin, direction)
            left = self.surfaces.distance(origin, direction, end[at]) > distance
            culled = at[left & self.box.culling[face]]
            rays.out = whole(rays.out, len(end)).copy()
            rays.out[at[left]] = True
            end[culled], final[culled], caster[culled] = CULLED, True, False
        at = np.flatnonzero(caster)
        if not self._within and len(at):
            origin, direction = (np.take(v, at, axis=1) for v in (rays.origin, rays.direction))
            outside = at[pick(rays.out, at) | ~self.box.contains(self._reached(origin, direction, end[at]))]
            end[outside], final[outside] = BLOCKED, True

    def _reached(self, origin, direction, triangle):
        """Where (3,k) rays meet bending triangles (k,)."""
        return self.surfaces.met(origin, direction, triangle.astype(np.int64) - self.surfaces.solid)[0]


def _told(rays, ended, end, codes):
    """What `Follower.ends` yields of the rays that ended (k,)."""
    if not ended.any():
        return
    ended = ended & rays.cast
    if codes is not None:
        ended &= np.take(codes.own, rays.code) & rays.want != 0
    at = chosen(ended)
    if some(at):
        yield rays.take(at).each(), end[at]
