"""The waters that accuracy is measured on: the pool of the tests, and waves, depths and suns drawn by seed."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import waves as tests_waves
from waves import OBLIQUE

from dapple.kernels.scene import Receiver, Scene, Sun

from .reference_light import Floor, refract
from .reference_waves import Sines

SEEDS = (1, 2, 3, 4, 5, 6)
SOLAR = np.radians(0.53)
_RELIEF = Sines(np.array([0.10, 0.06]), np.array([1.9, 1.1]), np.radians([35, 110]), np.array([0.4, 2.0]))
_RELIEF_QUADS = 160


@dataclass(frozen=True)
class Pond:
    """Waves at z = depth [m] over a square of `side` [m] round `centre` (2,), a Floor round the origin, and a sun:
    unit direction of travel, angle [rad] across its disc."""

    name: str
    waves: Sines
    depth: float
    direction: np.ndarray
    side: float = 4.8
    centre: tuple = (0.0, 0.0)
    floor: Floor = field(default_factory=Floor)
    angle: float = 0.0
    eta: float = 1.333

    @property
    def bounds(self):
        """Least and greatest x, y of the water."""
        return np.array(self.centre) - self.side / 2, np.array(self.centre) + self.side / 2

    def with_disc(self):
        return replace(self, name=f"{self.name}, sun 0.53°", angle=SOLAR)

    def with_relief(self):
        return _covered(replace(self, name=f"{self.name}, uneven", floor=Floor(self.floor.side, _RELIEF)))

    def scene(self, water):
        """The Scene of a Water over this pond's floor."""
        sun = Sun("Sun", self.direction, np.ones(3), self.angle)
        return Scene(water, (self._receiver(),), (), (sun,), self.eta)

    def _receiver(self):
        if self.floor.relief is None:
            return tests_waves.floor(self.floor.side)
        x, y, triangles = tests_waves.grid(_RELIEF_QUADS, self.floor.side)
        uv = np.stack([x, y], 1) / self.floor.side + 0.5
        return Receiver("Floor", np.stack([x, y, self.floor.relief(x, y)[0]], 1), triangles, uv[triangles])


def pool():
    """The pool of the tests."""
    shape = (tests_waves.AMPLITUDE, tests_waves.WAVELENGTH, tests_waves.HEADING, tests_waves.PHASE)
    return Pond("pool", Sines(*shape), 1.5, np.array(OBLIQUE) / np.linalg.norm(OBLIQUE))


def drawn(seed):
    """A Pond by chance: 5 to 8 sines of 0.25 to 2.5 m, slopes of 0.05 to 0.15, 0.6 to 3 m deep, the sun 5 to 55 degrees
    from overhead; as much water as lights the floor."""
    rng = np.random.default_rng(seed)
    count = rng.integers(5, 9)
    wavelength = np.exp(rng.uniform(np.log(0.25), np.log(2.5), count))
    slope = rng.uniform(0.3, 1.0, count)
    slope *= rng.uniform(0.05, 0.15) / np.sqrt((slope**2).sum() / 2)
    heading, phase = rng.uniform(0, 2 * np.pi, (2, count))
    waves = Sines(slope * wavelength / (2 * np.pi), wavelength, heading, phase)
    depth = np.exp(rng.uniform(np.log(0.6), np.log(3.0)))
    zenith, azimuth = np.radians(rng.uniform(5, 55)), rng.uniform(0, 2 * np.pi)
    direction = np.array([np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), -np.cos(zenith)])
    return _covered(Pond(f"seed {seed}", waves, depth, direction))


def _covered(pond, margin=0.1):
    """The Pond with the square of water that lights its floor, and a margin [m]."""
    x, y = np.meshgrid(*[np.linspace(-12, 12, 1200)] * 2)
    height, slope_x, slope_y = pond.waves(x, y)
    go_x, go_y, _ = refract(pond.direction, np.stack([-slope_x, -slope_y, np.ones_like(x)]), pond.eta)
    landed = pond.floor.land(x, y, pond.depth + height, go_x, go_y)
    lights = np.maximum(abs(landed[0]), abs(landed[1])) <= pond.floor.side / 2
    low, high = (np.array([reach(v[lights]) for v in (x, y)]) for reach in (np.min, np.max))
    side = float((high - low).max() + 2 * margin)
    return replace(pond, side=side, centre=tuple(float(v) for v in (low + high) / 2))
