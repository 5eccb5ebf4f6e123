"""What is measured of light over casters: errors of Dapple's maps, and the time to an error beside that of Mitsuba."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flip_evaluator
import numpy as np

from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Settings

from . import mitsuba_scene
from .accuracy_cases import timed
from .caster_references import irradiance, of_scene
from .mitsuba_camera import FloorCamera
from .mitsuba_light import LightTracer

RESOLUTION = 256
TOLERANCES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
GOAL = 1e-2
_FIRST = 2**12  # photons, of those that are doubled until the goal is reached
_MOST = 2**26
ERROR_HEAD = (
    "scene", "receiver", "asked", "CPU [s]", "error", "of 6 meetings", "MAE", "FLIP", "energy", "own estimate",
    "reference's error",
)  # fmt: skip
TIME_HEAD = (
    "scene", "Dapple asked", "error", "CPU [s]", "Mitsuba aimed [s]", "ratio", "at Dapple's error", "ptracer [s]",
    "ratio", "of the map seen",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """scene; name; camera: (side, height) of a `FloorCamera` that sees the first receiver, None where none can."""

    name: str
    scene: Any
    camera: tuple | None = None

    @cached_property
    def texels(self):
        return [rasterise(receiver, RESOLUTION) for receiver in self.scene.receivers]

    @cached_property
    def reference(self):
        return of_scene(self.scene, self.texels)

    def bake(self, tolerance, repeats=3):
        """CPU seconds of a bake, light (K,3), and what the solver says."""
        settings = Settings("photon_splat", tolerance, surface="mesh")
        seconds, solution = timed(lambda: solve(self.scene, self.texels, settings), repeats)
        pairs = zip(solution.images, self.texels, strict=True)
        return seconds, np.concatenate([image.reshape(-1, 3)[own.texel] for image, own in pairs]), solution.diagnostics

    def error_rows(self, tolerance):
        """Cells of ERROR_HEAD: one row of all receivers, and one of each where there are several."""
        seconds, light, work = self.bake(tolerance)
        reference, names = self.reference, [receiver.name for receiver in self.scene.receivers]
        parts = [(None, ", ".join(names))] + [(k, name) for k, name in enumerate(names) if len(names) > 1]
        for part, name in parts:
            first, estimate = part is None, work.estimated_error
            yield (
                self.name, name, f"{tolerance:.0e}", f"{seconds:.2f}" if first else "",
                f"{reference.maps.error(light, part):.1e}", f"{reference.short.error(light, part):.1e}",
                f"{reference.maps.mean_error(light, part):.3f}", f"{self._flip(light, part):.3f}",
                f"{100 * reference.maps.energy(light, part):+.2f} %",
                "-" if estimate is None or not first else f"{estimate:.1e}",
                f"{reference.errors[0 if first else part + 1]:.0e}",
            )  # fmt: skip

    def images(self, light):
        """Images (R,R,3) of light (K,3), one a receiver."""
        parts = np.split(light, self.reference.maps.cuts)
        return [own.image(part) for own, part in zip(self.texels, parts, strict=True)]

    def _flip(self, light, part):
        """HDR-FLIP of maps, the mean over receivers where `part` is None."""
        truth, found = self.images(self.reference.maps.light), self.images(light)
        chosen = range(len(truth)) if part is None else [part]
        pairs = [(truth[k].astype(np.float32), np.maximum(found[k], 0).astype(np.float32)) for k in chosen]
        return np.mean([flip_evaluator.evaluate(a, b, "HDR")[1] for a, b in pairs])

    def time_row(self):
        """Cells of TIME_HEAD: CPU seconds to the goal, Dapple's with the loosest of TOLERANCES that reaches it."""
        tolerance, error, seconds = self._dapple_time()
        own, camera, seen = self._photon_time(), None, "-"
        if self.camera:
            camera, seen = self._camera_time()

        def against(other):
            return "-" if other is None or seconds is None else f"{other / seconds:.1f}"

        return (
            self.name, f"{tolerance:.0e}", f"{error:.1e}", "not reached" if seconds is None else f"{seconds:.3f}",
            f"{own:.3f}", against(own), against(own * GOAL / error),
            "-" if camera is None else f"{camera:.2f}", against(camera), seen,
        )  # fmt: skip

    def _dapple_time(self):
        for tolerance in TOLERANCES:
            seconds, light, _ = self.bake(tolerance, 5)
            error = self.reference.maps.error(light)
            if error <= GOAL:
                return tolerance, error, seconds
        return tolerance, error, None

    def _photon_time(self):
        """CPU seconds of `mitsuba_light` to the goal, of a loaded scene and with its kernels compiled."""
        tracer = LightTracer(self.scene, mitsuba_scene.load(self.scene), RESOLUTION)

        def run(photons):
            return self.reference.maps.error(irradiance(self.texels, tracer.throw(photons, 77).maps))

        return time_to(GOAL, run)

    def _camera_time(self):
        """The same of `ptracer`, on the texels that its camera sees, and their part."""
        camera = FloorCamera(self.scene, *self.camera, RESOLUTION)
        count = len(self.texels[0].texel)
        truth = self.texels[0].image(self.reference.maps.light[:count])[camera.seen]

        def run(photons):
            picture = camera.caustics(max(1, round(photons / RESOLUTION**2)), 77)[camera.seen]
            return ((picture - truth) ** 2).sum() / (truth**2).sum()

        return time_to(GOAL, run, RESOLUTION**2), f"{camera.seen.mean():.0%}"


def time_to(goal, run, first=_FIRST):
    """CPU seconds until run(photons) returns no more than `goal`: photons are doubled until it does or until there are
    _MOST, and the time of the last run is scaled to the goal, as the error falls with 1 / photons."""
    photons = first
    while True:
        run(photons)
        start = time.process_time()
        error = run(photons)
        seconds = time.process_time() - start
        if error <= goal or photons >= _MOST:
            return seconds * error / goal
        photons *= 2
