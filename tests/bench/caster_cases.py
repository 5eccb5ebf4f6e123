"""What is measured of light over casters: errors of Dapple's maps, and the time to an error beside that of Mitsuba."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import flip_evaluator
import numpy as np

from dapple.kernels.chart.maps import light_of
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings

from . import mitsuba_scene
from .accuracy_cases import timed
from .caster_references import irradiance, of_scene
from .mitsuba_camera import MapCamera, View
from .mitsuba_light import LightTracer

RESOLUTION = 256
TOLERANCES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
GOAL = 1e-2
_PHOTONS = 2**22  # of Mitsuba's, of which times are taken
ERROR_HEAD = (
    "scene", "receiver", "method", "asked", "CPU [s]", "error", "of 6 meetings", "MAE", "FLIP", "energy",
    "own estimate", "reference's error", "its MAE", "its FLIP",
)  # fmt: skip
TIME_HEAD = (
    "scene", "Dapple asked", "error", "MAE", "CPU [s]", "Mitsuba, aimed [s]", "ratio", "ratio at Dapple's error",
    "ratio at its MAE", "ptracer [s]", "ratio", "else apart by", "of the map seen",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Case:
    """name; scene; camera: the View of a `MapCamera` on the first receiver."""

    name: str
    scene: Any
    camera: View
    _bakes: dict = field(default_factory=dict, init=False)

    @cached_property
    def texels(self):
        return [rasterise(receiver, RESOLUTION) for receiver in self.scene.receivers]

    @cached_property
    def reference(self):
        return of_scene(self.scene, self.texels)

    def bake(self, tolerance, method="photon_splat"):
        """CPU seconds of a bake, light (K,3), and what the solver says."""
        key = tolerance, method
        if key not in self._bakes:
            settings = Settings(method, tolerance, surface="mesh")
            seconds, solution = timed(lambda: solve(self.scene, self.texels, settings), 3)
            self._bakes[key] = seconds, light_of(self.texels, solution.images), solution.diagnostics
        return self._bakes[key]

    def error_rows(self, tolerance, method="photon_splat"):
        """Cells of ERROR_HEAD: one row of all receivers, and one of each where there are several."""
        seconds, light, work = self.bake(tolerance, method)
        names = [receiver.name for receiver in self.scene.receivers]
        rest = enumerate(names) if len(names) > 1 else ()
        for part, name in ((None, "all" if len(names) > 1 else names[0]), *rest):
            first = part is None
            yield (
                self.name, name, method, f"{tolerance:.0e}", f"{seconds:.2f}" if first else "",
                *self._errors(light, part),
                f"{work.estimated_error:.1e}" if first and work.estimated_error is not None else "",
                *self._noise(part),
            )  # fmt: skip

    def images(self, light):
        """Images (R,R,3) of light (K,3), one a receiver."""
        parts = np.split(light, self.reference.maps.cuts)
        return [own.image(part) for own, part in zip(self.texels, parts, strict=True)]

    def _errors(self, light, part):
        """Cells from the error to the energy."""
        maps, short = self.reference.maps, self.reference.short
        return (
            f"{maps.error(light, part):.1e}", f"{short.error(light, part):.1e}", f"{maps.mean_error(light, part):.3f}",
            f"{self._flip(light, part):.3f}", f"{100 * maps.energy(light, part):+.2f} %",
        )  # fmt: skip

    def _noise(self, part):
        maps, half = self.reference.maps, self.reference.half
        return f"{maps.error(half, part):.0e}", f"{maps.mean_error(half, part):.3f}", f"{self._flip(half, part):.3f}"

    def _flip(self, light, part):
        """HDR-FLIP of maps, the mean over receivers where `part` is None."""
        truth, found = self.images(self.reference.maps.light), self.images(light)
        chosen = range(len(truth)) if part is None else [part]
        pairs = [(truth[k].astype(np.float32), np.maximum(found[k], 0).astype(np.float32)) for k in chosen]
        return np.mean([flip_evaluator.evaluate(a, b, "HDR")[1] for a, b in pairs])

    def time_row(self):
        """Cells of TIME_HEAD: CPU seconds to the goal, Dapple's with the loosest of TOLERANCES that reaches it.

        Mitsuba's are those of many photons scaled to the error, which falls with 1 / photons, and to the mean absolute
        one, which falls with its root: what few photons cost besides is left out.
        """
        tolerance, error, mean_error, seconds = self._to_goal()
        spent, its_error, its_mean = self._photons()
        camera, *apart = self._camera()
        times = spent * its_error / GOAL, spent * its_error / error, spent * (its_mean / mean_error) ** 2
        return (
            self.name, f"{tolerance:.0e}", f"{error:.1e}", f"{mean_error:.3f}", f"{seconds:.3f}", f"{times[0]:.3f}",
            *(f"{time / seconds:.2f}" for time in times), f"{camera:.2f}", f"{camera / seconds:.1f}", *apart,
        )  # fmt: skip

    def _to_goal(self):
        """Tolerance, error, mean absolute error and CPU seconds of the first bake that reaches the goal, or last."""
        for tolerance in TOLERANCES:
            seconds, light, _ = self.bake(tolerance)
            error = self.reference.maps.error(light)
            if error <= GOAL:
                break
        return tolerance, error, self.reference.maps.mean_error(light), seconds

    def _photons(self):
        """CPU seconds, error and mean absolute error of _PHOTONS of `mitsuba_light`, with all compiled and loaded."""
        tracer = LightTracer(self.scene, mitsuba_scene.load(self.scene), RESOLUTION)
        tracer.throw(_PHOTONS, 76)
        start = time.process_time()
        landed = tracer.throw(_PHOTONS, 77)
        seconds, maps = time.process_time() - start, self.reference.maps
        light = irradiance(self.texels, landed.maps)
        return seconds, maps.error(light), maps.mean_error(light)

    def _camera(self):
        """Cells of what `ptracer` makes of it: CPU seconds to the goal by the noise of light that met something, told
        from two pictures; their error without it; and how much of the map its camera sees.

        Mitsuba's sun has no disc, and a pixel is no texel: that is in the error, and not in the noise.
        """
        camera, own = MapCamera(self.scene, self.camera, self.texels[0]), self.texels[0]
        truth = camera.of(own.image(self.reference.maps.light[: len(own.texel)]))[camera.seen]
        paths = max(1, _PHOTONS // camera.seen.size)
        camera.whole(paths, 76)
        start = time.process_time()
        camera.whole(paths, 77)
        seconds = time.process_time() - start
        one, other = (camera.caustics(paths, seed)[camera.seen] for seed in (78, 79))
        noise = ((one - other) ** 2).mean() / 2 / (truth**2).mean()
        rest = ((one - truth) * (other - truth)).mean() / (truth**2).mean()
        part = camera.seen.mean() * (self.camera.side**2 / own.area.sum())
        return seconds * noise / GOAL, f"{rest:.0e}", f"{part:.0%}"
