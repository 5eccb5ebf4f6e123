"""The reference against closed forms: what the tables say before they judge anything by it."""

from __future__ import annotations

import numpy as np
import waves as tests_waves
from casters import no_water

from dapple.kernels.casters import Glass, Mirror
from dapple.kernels.chart.maps import Maps
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.methods import solve
from dapple.kernels.scene import Occluder, Point, Scene, Settings, Sun

from . import caster_shapes as shapes
from . import mitsuba_scene
from .caster_references import irradiance
from .caster_scenes import on_table
from .mitsuba_light import LightTracer

HEAD = ("check", "expected", "reference", "off by")
_PHOTONS = 2**22
_RESOLUTION = 64


def rows():
    """(check, expected, reference, off by) of each check."""
    for check in (_slab, _mirror, _closed_box, _ball, _pool):
        yield from check()


def _landed(scene, photons=_PHOTONS, seed=0):
    """Light (K,3), the Texels and what landed, of a Scene."""
    texels = [rasterise(receiver, _RESOLUTION) for receiver in scene.receivers]
    landed = LightTracer(scene, mitsuba_scene.load(scene), _RESOLUTION).throw(photons, seed)
    return irradiance(texels, landed.maps), texels, landed


def _row(name, expected, found):
    return name, f"{expected:.6g}", f"{found:.6g}", f"{100 * (found / expected - 1):+.3f} %"


def _slab():
    """A plate with parallel faces: all orders of reflections inside pass (1 - R)^2 a / (1 - R^2 a^2); where its own
    shadow would lie, and shifted by less than the plate is thick."""
    cos_i, eta, sigma, thick = np.cos(np.radians(40)), 1.5, 8.0, 0.05
    glass = Glass(eta, np.array([0.0, sigma, 2 * sigma]))
    direction = (np.sin(np.radians(40)), 0, -cos_i)
    plate = shapes.caster("Plate", shapes.box([2.0, 2.0, thick]), glass, (0, 0, 0.1), flat=True)
    scene = on_table(plate, side=0.5, direction=direction, lights=(Sun("Sun", np.array(direction), np.ones(3)),))
    light, _, _ = _landed(scene)
    reflected = 1 - tests_waves.transmitted(cos_i, eta)
    for channel, k in enumerate(("clear", "green", "blue")):
        a = np.exp(-channel * sigma * thick / np.sqrt(1 - (np.sin(np.radians(40)) / eta) ** 2))
        expected = cos_i * (1 - reflected) ** 2 * a / (1 - (reflected * a) ** 2)
        yield _row(f"plate at 40 degrees, {k}: irradiance below it", expected, light[:, channel].mean())


def _mirror():
    """Light off a mirror at 45 degrees onto a wall: Schlick's curve, and the mirror's own size."""
    mirror = Mirror(np.array([0.9, 0.5, 0.1]), np.array([1.0, 0.8, 0.6]))
    panel = shapes.caster("Panel", shapes.box([1.0, 1.0, 0.01]), mirror, (0, 0, -0.005), flat=True)
    wall = tests_waves.quad("Wall", [[1, -1, 0], [1, -1, 2], [1, 1, 2], [1, 1, 0]])
    direction = np.array([1, 0, -1]) / np.sqrt(2)
    scene = Scene(no_water(), (wall,), (), (Sun("Sun", direction, np.ones(3)),), casters=(panel,))
    light, texels, _ = _landed(scene)
    share = mirror.f0 + (mirror.f90 - mirror.f0) * (1 - np.sqrt(0.5)) ** 5
    flux = texels[0].area @ light
    for channel in range(3):
        yield _row(
            f"mirror at 45 degrees, channel {channel}: flux on the wall", share[channel] / np.sqrt(2), flux[channel]
        )


def _closed_box():
    """A clear glass ball and a lamp in a closed box: what meets the ball lands on the box."""
    corners = shapes.box([2.0, 2.0, 2.0])[0]
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    walls = tuple(tests_waves.quad(f"Wall {k}", corners[quad[::-1]]) for k, quad in enumerate(quads))
    ball = shapes.caster("Ball", shapes.ball(0.3, 512), Glass(1.5))
    lamp = Point("Lamp", np.array([-0.7, 0.1, 0.3]), np.ones(3))
    light, texels, landed = _landed(Scene(no_water(), walls, (), (lamp,), casters=(ball,)))
    away = np.linalg.norm(lamp.position)
    expected = 2 * np.pi * (1 - np.sqrt(1 - (0.3 / away) ** 2))
    flux = Maps.of(texels, light).weight @ light
    yield _row("ball in a closed box: flux on the walls", expected, flux[0])
    yield "of it, on the wrong side of facets", "0", f"{landed.lost['wrong_side'][0]:.2g}", "-"


def _ball():
    """Light near the axis of a ball crosses it n R / (2 (n - 1)) from the centre: a thin beam's image is a point
    there, and twice as wide as half way."""
    eta, radius, aperture = 1.5, 1.0, 0.02
    focus = eta * radius / (2 * (eta - 1))
    ball = shapes.caster("Ball", shapes.ball(radius, 512), Glass(eta))
    for name, height, side in (("at the focus", focus, 0.008), ("one radius beyond it", focus + radius, 0.08)):
        floor = tests_waves.floor(side, -height)
        hole = _blind(aperture, 2.0)
        scene = Scene(no_water(), (floor,), hole, (tests_waves.sun((0, 0, -1)),), casters=(ball,))
        light, texels, _ = _landed(scene, 2**25)
        at = np.hypot(*texels[0].positions[:, :2].T)
        weight = light[:, 0] * texels[0].area * (at < 2 * aperture)
        spread = np.sqrt((weight * at**2).sum() / weight.sum())
        if height > focus:
            yield _row(
                f"ball, thin beam {name}: radius of its image [m]", aperture * radius / focus / np.sqrt(2), spread
            )
        else:
            yield f"ball, thin beam {name}: radius of its image [m]", "0", f"{spread:.2g}", f"{spread:.1e} m"


def _blind(hole, half):
    """Occluders above a ball that leave a round hole about the z axis."""
    angle, rings = np.linspace(0, 2 * np.pi, 257), np.array([hole, 2 * half])
    positions, triangles = shapes.sheet(
        lambda r, a: np.stack([r * np.cos(a), r * np.sin(a), np.full_like(r, 1.5)], -1), rings, angle
    )
    return (Occluder("Blind", positions, triangles),)


def _pool():
    """The pool of the tests, without casters: the beams that are measured against references of another kind."""
    scene = tests_waves.pool(quads=128)
    light, texels, _ = _landed(scene, 2**24)
    found = solve(scene, texels, Settings(tolerance=1e-5, surface="mesh"))
    flat = found.images[0].reshape(-1, 3)[texels[0].texel]
    maps = Maps.of(texels, light)
    yield _row(
        "pool: flux on the floor, expected by beams", float(maps.weight @ flat[:, 0]), float(maps.weight @ light[:, 0])
    )
    yield "pool: relMSE of the reference against beams", "0", f"{maps.error(flat):.1e}", "-"
