"""Mitsuba's own `ptracer` at work on a map: a camera that looks straight down on a receiver."""

from __future__ import annotations

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from . import mitsuba_scene

_INNER = 4  # rays along the side of a pixel that tell which texels it sees
_DEPTHS = 64, 2  # surfaces and the lens: of all light, and of what comes straight from the lights


@dataclass(frozen=True)
class View:
    """From origin (3,) [m] down on a square of `side` [m] at z = level."""

    origin: tuple
    side: float
    level: float = 0.0


class MapCamera:
    """Pictures of a Scene's first receiver in a View, some (R,R) pixels, each about as large as a texel.

    seen (R,R) bool: pixels to which nothing hides the receiver, nor to their neighbours; texel (R,R,n): which it sees
    at each of n places in a pixel.
    """

    def __init__(self, scene, view, texels):
        loaded = mitsuba_scene.load(scene, emitters=True)
        self._scene, self._side = loaded.scene, texels.resolution
        width = np.sqrt(texels.area.sum() / len(texels.area))
        self._pixels = max(8, round(view.side / width))
        height = view.origin[2] - view.level
        film = {
            "type": "hdrfilm", "width": self._pixels, "height": self._pixels, "rfilter": {"type": "box"},
            "pixel_format": "rgb", "component_format": "float32",
        }  # fmt: skip
        x, y, _ = view.origin
        place = mi.ScalarTransform4f().look_at(origin=list(view.origin), target=[x, y, view.level], up=[0, 1, 0])
        self._camera = mi.load_dict({
            "type": "perspective", "fov": float(2 * np.degrees(np.arctan(view.side / 2 / height))), "to_world": place,
            "near_clip": height / 100, "far_clip": 4 * height, "film": film,
        })  # fmt: skip
        hit, self.texel = self._look(loaded.receivers[0])
        around = np.pad(hit, 1)
        shifts = [around[i : i + self._pixels, j : j + self._pixels] for i in range(3) for j in range(3)]
        self.seen = np.all(shifts, axis=0)

    def caustics(self, paths_per_pixel, seed):
        """Irradiance (R,R,3) [W/m^2] by ptracer, less the part of the very same paths that comes straight from the
        lights, whose noise cancels."""
        return self.whole(paths_per_pixel, seed) - self.straight(paths_per_pixel, seed)

    def whole(self, paths_per_pixel, seed):
        """As `caustics`, of all light, which is what ptracer spends its time on."""
        return self._picture(_DEPTHS[0], paths_per_pixel, seed)

    def straight(self, paths_per_pixel, seed):
        """As `whole`, of the light that meets nothing on its way."""
        return self._picture(_DEPTHS[1], paths_per_pixel, seed)

    def of(self, image):
        """What of an image (R,R,3) of the receiver the pixels see, (R,R,3)."""
        return image.reshape(-1, 3)[self.texel].mean(2)

    def on_map(self, picture):
        """What of a picture (R,R,...) of pixels falls on the map's texels (R^2,...), where a pixel is a texel; 0 where
        the receiver is not seen."""
        image = np.zeros((self._side**2, *picture.shape[2:]), picture.dtype)
        image[self.texel[self.seen][:, _INNER * (_INNER + 1) // 2]] = picture[self.seen]
        return image

    def _picture(self, depth, samples, seed):
        """Irradiance (R,R,3) of the receiver: a white surface's radiance is E albedo / pi."""
        integrator = mi.load_dict({"type": "ptracer", "max_depth": depth, "rr_depth": depth + 1})
        picture = mi.render(self._scene, sensor=self._camera, integrator=integrator, spp=samples, seed=seed)
        return np.array(picture, np.float64) * np.pi / mitsuba_scene.WHITE

    def _look(self, receiver):
        """Whether (R,R) all that a pixel sees is the receiver, and which texels (R,R,inner^2)."""
        grid = (np.arange(self._pixels * _INNER) + 0.5) / (self._pixels * _INNER)
        x, y = (mi.Float(v.ravel().astype(np.float32)) for v in np.meshgrid(grid, grid))
        ray, _ = self._camera.sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5))
        found = self._scene.ray_intersect(ray)
        hit = np.array(found.shape == mi.ShapePtr(receiver))
        u, v = (np.clip(np.nan_to_num(np.array(c)) * self._side, 0, self._side - 1).astype(int) for c in found.uv)
        hit, texel = (a.reshape(self._pixels, _INNER, self._pixels, _INNER) for a in (hit, v * self._side + u))
        return hit.all((1, 3)), texel.transpose(0, 2, 1, 3).reshape(self._pixels, self._pixels, -1)
