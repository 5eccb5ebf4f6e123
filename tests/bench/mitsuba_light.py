"""Irradiance of receivers by light tracing with Mitsuba 3: what met water, glass or a mirror, left on texels.

Photons start stratified, go at random where Fresnel's equations leave a choice, and end on the first surface that is
not specular. They are aimed at one specular mesh after the other, through a rectangle across a Sun's light that covers
it, or into a lamp's cone about it, and those that come to another surface first are left to that one's turn. Nothing is
shared with `kernels` but the description of the scene.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi
import numpy as np

from dapple.kernels.scene import Point, Spot

# How photons end: on a surface or nowhere, on a back, bent to the wrong side of a facet, with patience spent.
_ENDED, _BACK, _WRONG_SIDE, _ENDLESS = range(4)
_PATIENCE = 64  # surfaces a photon may meet
_BATCH = 2**22  # photons at once
_OFF = 4e-6  # of the scene's size: how far off a surface rays go on; Mitsuba's own offset is a tenth of a millimetre


@dataclass
class Landed:
    """Flux of photons: maps, per receiver (R,R,3) [W], row 0 at v = 0; short: the same of photons that met no more than
    `bounces` specular surfaces; lost: cause -> (3,) [W]; photons: how many started."""

    maps: list
    short: list
    lost: dict = field(default_factory=dict)
    photons: int = 0

    def add(self, other, share=1.0):
        for mine, theirs in ((self.maps, other.maps), (self.short, other.short)):
            for image, more in zip(mine, theirs, strict=True):
                image += share * more
        for cause, watts in other.lost.items():
            self.lost[cause] = self.lost.get(cause, np.zeros(3)) + share * watts
        self.photons += other.photons


class LightTracer:
    """Photons of a Scene's lights through `loaded`, the same as a `mitsuba_scene.Loaded`."""

    def __init__(self, scene, loaded, resolution, bounces=6):
        self._lights, self._traced, self._resolution, self._bounces = scene.lights, loaded.scene, resolution, bounces
        self._shapes = [mi.ShapePtr(shape) for shape in loaded.receivers]
        self._aims = [(mi.ShapePtr(shape), np.unique(points, axis=0)) for shape, points in loaded.specular]
        bounds = loaded.scene.bbox()
        self._size = float(dr.norm(bounds.max - bounds.min))

    def throw(self, photons, seed):
        """What `photons` bring, shared alike among the pairs of a light and a specular mesh."""
        total = self._nothing()
        pairs = [(light, *aim) for light in self._lights for aim in self._aims]
        batches = max(1, round(photons / len(pairs) / _BATCH))
        side = max(1, round((photons / len(pairs) / batches) ** 0.5))
        for number in range(batches * len(pairs)):
            total.add(self._batch(*pairs[number % len(pairs)], side, seed * 100003 + number), 1 / batches)
        return total

    def _nothing(self):
        zeros = [[np.zeros((self._resolution, self._resolution, 3)) for _ in self._shapes] for _ in range(2)]
        return Landed(*zeros)

    def _batch(self, light, aim, points, side, seed):
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, side * side)
        index = dr.arange(mi.UInt32, side * side)
        at = (mi.Point2f(mi.Float(index % side), mi.Float(index // side)) + sampler.next_2d()) / side
        if isinstance(light, Point):
            ray, flux = _of_lamp(light, points, at)
        else:
            ray, flux = self._of_sun(light, points, at, sampler)
        path = _follow(self._traced, ray, flux / (side * side), aim, _OFF * self._size, sampler)
        dr.eval(*path)  # once, not again for every sum
        return self._collect(*path, side * side)

    def _of_sun(self, sun, points, at, sampler):
        """Rays of a Sun for points `at` of the unit square, and the flux [W] that all of them carry together."""
        axis = np.asarray(sun.direction, float)
        across = mi.Frame3f(mi.Vector3f(axis))
        x, y = (np.array(v, float).ravel() for v in (across.s, across.t))
        deep = points @ axis
        spread = np.tan(sun.angle / 2) * np.ptp(deep)  # its disc lights what lies beside the axis
        low, high = (np.array([edge(points @ v) for v in (x, y)]) for edge in (np.min, np.max))
        low, high = low - spread, high + spread
        u, v = (at[k] * float(high[k] - low[k]) + float(low[k]) for k in range(2))
        # Even over the disc as it is seen along the axis: then the irradiance across the axis is even in its light.
        disc = mi.warp.square_to_uniform_disk(sampler.next_2d()) * float(np.sin(sun.angle / 2))
        direction = across.to_world(mi.Vector3f(disc.x, disc.y, dr.sqrt(1 - dr.squared_norm(disc))))
        entry = mi.Point3f(x) * u + mi.Point3f(y) * v + mi.Point3f(axis * deep.min())
        return mi.Ray3f(entry - direction * self._size, direction), mi.Color3f(sun.irradiance * np.prod(high - low))

    def _collect(self, shape, uv, met, throughput, state, photons):
        """Landed, from where photons ended."""
        side = self._resolution
        landed = self._nothing()
        landed.photons = photons
        specular, on_receiver = met > 0, mi.Bool(False)
        cell = mi.UInt32(dr.clip(uv.y * side, 0, side - 1)) * side + mi.UInt32(dr.clip(uv.x * side, 0, side - 1))
        for number, pointer in enumerate(self._shapes):
            on_receiver |= shape == pointer
            here = (shape == pointer) & (state == _ENDED)
            for images, counted in ((landed.maps, specular), (landed.short, specular & (met <= self._bounces))):
                for channel in range(3):
                    sums = dr.zeros(mi.Float, side * side)
                    dr.scatter_reduce(dr.ReduceOp.Add, sums, throughput[channel], cell, here & counted)
                    images[number][:, :, channel] = np.array(sums, np.float64).reshape(side, side)
        nowhere = shape == dr.zeros(mi.ShapePtr)
        causes = {
            "missed": nowhere & (state == _ENDED), "occluded": ~nowhere & ~on_receiver & (state <= _BACK),
            "back": on_receiver & (state == _BACK), "wrong_side": state == _WRONG_SIDE, "endless": state == _ENDLESS,
        }  # fmt: skip
        for cause, here in causes.items():
            lost = dr.select(here & specular, throughput, 0)
            landed.lost[cause] = np.array([float(np.array(lost[k], np.float64).sum()) for k in range(3)])
        return landed


def _of_lamp(lamp, points, at):
    """Rays of a lamp into the cone about points, for `at` of the unit square, and the flux [W] of all together."""
    centre = (points.max(0) + points.min(0)) / 2
    radius = np.linalg.norm(points - centre, axis=1).max()
    axis, away = centre - lamp.position, np.linalg.norm(centre - lamp.position)
    cosine = np.sqrt(1 - (radius / away) ** 2) if away > radius else -1.0
    frame = mi.Frame3f(mi.Vector3f(axis / max(away, 1e-9)))
    cos = 1 - at.x * float(1 - cosine)
    sine, azimuth = dr.safe_sqrt(1 - cos * cos), 2 * dr.pi * at.y
    direction = dr.normalize(frame.to_world(mi.Vector3f(sine * dr.cos(azimuth), sine * dr.sin(azimuth), cos)))
    flux = mi.Color3f(lamp.intensity * 2 * np.pi * (1 - cosine))
    if isinstance(lamp, Spot):
        flux *= _falloff(lamp, direction)
    return mi.Ray3f(mi.Point3f(lamp.position), direction), flux


@dr.syntax
def _follow(traced, ray, throughput, aim, off, sampler):
    """Where photons end that meet the shape `aim` first: shape, uv, specular surfaces met (0 for all others),
    throughput, and state, how they ended."""
    context = mi.BSDFContext(mi.TransportMode.Importance)
    ray, throughput = mi.Ray3f(ray), mi.Color3f(throughput)
    active, met, state = mi.Bool(True), mi.UInt32(0), mi.UInt32(0)
    shape, uv, medium = dr.zeros(mi.ShapePtr), mi.Point2f(0), dr.zeros(mi.MediumPtr)
    while active:
        si = traced.ray_intersect(ray, active)
        hit = active & si.is_valid() & ((met > 0) | (si.shape == aim))
        within = hit & (medium != dr.zeros(mi.MediumPtr))
        inside = dr.zeros(mi.MediumInteraction3f)
        _, _, sigma = medium.get_scattering_coefficients(inside, within)
        throughput[within] = throughput * dr.exp(-sigma * si.t)
        bsdf = si.bsdf(ray)
        bend = hit & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Delta)
        shape = dr.select(active & ~bend, si.shape, shape)
        uv = dr.select(active & ~bend, si.uv, uv)
        state[hit & ~bend & (dr.dot(si.n, ray.d) >= 0)] = mi.UInt32(_BACK)
        out, weight = bsdf.sample(context, si, sampler.next_1d(bend), sampler.next_2d(bend), bend)
        wo = si.to_world(out.wo)
        came, goes = dr.dot(si.n, -ray.d), dr.dot(si.n, wo)
        passes = mi.has_flag(out.sampled_type, mi.BSDFFlags.DeltaTransmission)
        sound = (came * mi.Frame3f.cos_theta(si.wi) > 0) & ((came * goes < 0) == passes)
        state[bend & ~sound] = mi.UInt32(_WRONG_SIDE)
        throughput[bend] = throughput * weight
        met[bend] = met + 1
        medium[bend & passes & si.is_medium_transition()] = si.target_medium(wo)
        ray[bend] = mi.Ray3f(si.p + dr.mulsign(si.n, goes) * off, wo)
        active = bend & sound
        state[active & (met >= _PATIENCE)] = mi.UInt32(_ENDLESS)
        active &= (met < _PATIENCE) & (dr.max(throughput) > 0)
    return shape, uv, met, throughput, state


def _falloff(spot, direction):
    """Share of a Spot's intensity along directions: smoothstep over the blend, about +z of its frame."""
    local = mi.Matrix3f(np.asarray(spot.frame, np.float64)) @ direction
    cosine, edge = local.z / dr.norm(local), float(np.cos(spot.half_angle))
    x = dr.clip((cosine - edge) / max((1 - edge) * spot.blend, 1e-9), 0, 1)
    return x * x * (3 - 2 * x)
