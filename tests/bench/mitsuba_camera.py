"""Mitsuba's own `ptracer` at work on a map: a camera that looks straight at a plane floor, a pixel to a texel."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from . import mitsuba_scene

_DIRECT_SAMPLES = 64


class FloorCamera:
    """Pictures of a Scene's first receiver, a square of `side` [m] round the origin at z = 0, from `height` [m] above
    it; seen (R,R) bool: texels to which nothing specular hides the camera, nor to their neighbours."""

    def __init__(self, scene, side, height, resolution):
        self._scene = mitsuba_scene.load(scene, emitters=True).scene
        view = mi.ScalarTransform4f().look_at(origin=[0, 0, height], target=[0, 0, 0], up=[0, 1, 0])
        film = {
            "type": "hdrfilm", "width": resolution, "height": resolution, "rfilter": {"type": "box"},
            "pixel_format": "rgb", "component_format": "float32",
        }  # fmt: skip
        camera = {
            "type": "perspective", "fov": float(2 * np.degrees(np.arctan(side / 2 / height))), "to_world": view,
            "near_clip": height / 100, "far_clip": 2 * height, "film": film,
        }  # fmt: skip
        self._camera, self._resolution = mi.load_dict(camera), resolution
        self.seen = self._free(side, height)
        self._direct = self._picture({"type": "direct"}, _DIRECT_SAMPLES, 0)

    def caustics(self, paths_per_texel, seed):
        """Irradiance (R,R,3) [W/m^2] by ptracer, less what comes straight from the lights without its noise."""
        return self._picture({"type": "ptracer", "max_depth": 64, "rr_depth": 65}, paths_per_texel, seed) - self._direct

    def _picture(self, integrator, samples, seed):
        """Irradiance of the floor, row 0 at the least y: a white floor's radiance is E albedo / pi."""
        picture = mi.render(
            self._scene, sensor=self._camera, integrator=mi.load_dict(integrator), spp=samples, seed=seed
        )
        return np.array(picture, np.float64)[::-1] * np.pi / mitsuba_scene.WHITE

    def _free(self, side, height):
        axis = (np.arange(self._resolution) + 0.5) / self._resolution * side - side / 2
        x, y = (v.ravel().astype(np.float32) for v in np.meshgrid(axis, axis))
        floor, eye = mi.Point3f(x, y, 0.0), mi.Point3f(0, 0, height)
        ray = mi.Ray3f(eye, dr.normalize(floor - eye))
        hidden = self._scene.ray_test(mi.Ray3f(ray.o, ray.d, 0.999 * dr.norm(floor - eye), 0.0, []))
        grown = np.pad(np.array(hidden).reshape(self._resolution, -1), 1)
        around = [
            grown[1 + i : grown.shape[0] - 1 + i, 1 + j : grown.shape[1] - 1 + j]
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        ]
        return ~np.any(around, axis=0)
