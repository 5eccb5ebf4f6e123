"""The scenes on which light over casters is measured: some made of arrays here, and the sample .blend files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import waves as tests_waves

from dapple.kernels.scene import Glass, Mirror, Occluder, Point, Scene, Spot, Water

from . import caster_shapes as shapes

ROOT = Path(__file__).resolve().parents[2]
SUN = (0.5, 0.22, -1.0)
CROWN = Glass(1.5)
GREEN = Glass(1.52, np.array([6.0, 1.0, 4.0]))
DIAMOND = Glass(2.417)
SILVER = Mirror(np.full(3, 0.95), np.ones(3))
GOLD = Mirror(np.array([1.0, 0.77, 0.34]), np.ones(3))
LIGHT = np.array([3.0, 2.9, 2.7])


def dry():
    """A Water without triangles."""
    none = np.zeros((0, 3))
    return Water("Water", none, none.astype(int), none, none.astype(int), np.zeros(0, int))


def on_table(*casters, side=1.0, direction=SUN, lights=None):
    """A Scene of casters over a square table round the origin under a sun."""
    lights = (tests_waves.sun(direction, LIGHT),) if lights is None else lights
    return Scene(dry(), (tests_waves.floor(side),), (), lights, casters=casters)


def ball():
    """A glass ball above a table."""
    return on_table(shapes.caster("Ball", shapes.ball(0.12), CROWN, (-0.05, 0, 0.16)))


def slab():
    """A thick plate of green glass."""
    return on_table(shapes.caster("Slab", shapes.box([0.4, 0.3, 0.08], 0.3), GREEN, (0, 0, 0.2), flat=True))


def stone():
    """A cut stone, near enough to the table to throw small, hard patches."""
    return on_table(shapes.caster("Stone", shapes.stone(0.12), DIAMOND, (0, 0, 0.12), flat=True))


def ring():
    """A ring of glass, seen through twice."""
    return on_table(shapes.caster("Ring", shapes.ring(0.16, 0.035), CROWN, (-0.02, 0, 0.05)))


def cup():
    """A round mirror about a spot of a table: the nephroid."""
    return on_table(shapes.caster("Cup", shapes.trough(0.25, 0.15), SILVER), direction=(1, 0, -0.5))


def glass():
    """Ball, plate, stone and ring together on one table."""
    return on_table(
        shapes.caster("Ball", shapes.ball(0.12), CROWN, (-0.35, 0.3, 0.14)),
        shapes.caster("Ring", shapes.ring(0.14, 0.03), CROWN, (0.25, 0.3, 0.04)),
        shapes.caster("Stone", shapes.stone(0.12), DIAMOND, (-0.3, -0.3, 0.12), flat=True),
        shapes.caster("Slab", shapes.box([0.3, 0.2, 0.06], 0.3), GREEN, (0.25, -0.3, 0.2), flat=True),
        side=1.6,
    )


def mirror_room():
    """A room with a ball, a cup and a tilted panel as mirrors, a lamp and a spot; floor, ceiling and two walls."""
    x, y, z = 2.0, 1.5, 2.5
    quad = tests_waves.quad
    receivers = (
        quad("Floor", [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]),
        quad("Ceiling", [[-x, -y, z], [-x, y, z], [x, y, z], [x, -y, z]]),
        quad("Back", [[-x, y, 0], [x, y, 0], [x, y, z], [-x, y, z]]),
        quad("Side", [[x, -y, 0], [x, -y, z], [x, y, z], [x, y, 0]]),
    )
    casters = (
        shapes.caster("Ball", shapes.ball(0.3), SILVER, (-0.9, 0.5, 0.4)),
        shapes.caster("Cup", shapes.trough(0.5, 0.35), GOLD, (0.5, -0.2, 0.002)),
        shapes.caster("Panel", shapes.box([0.02, 0.9, 0.7], 0.4), SILVER, (1.5, -0.6, 1.4), flat=True),
    )
    axis = np.array([1.0, -0.35, -0.55])
    axis /= np.linalg.norm(axis)
    side = np.cross(axis, [0, 0, 1.0])
    side /= np.linalg.norm(side)
    lights = (
        Point("Lamp", np.array([-1.2, -0.9, 1.9]), np.array([3.0, 2.6, 2.0])),
        Spot("Spot", np.array([-1.5, 0.8, 2.2]), np.array([8.0, 9.0, 10.0]),
             frame=np.stack([side, np.cross(axis, side), axis]), half_angle=0.35, blend=0.3),
    )  # fmt: skip
    return Scene(dry(), receivers, (), lights, casters=casters)


def lagoon():
    """Water over an uneven bed, fish in it, a hull on it that takes light from the water."""

    def bed(x, y):
        return 0.22 * np.sin(1.7 * x + 0.4) * np.cos(1.3 * y) + 0.08 * np.sin(4.1 * x - 2.3 * y)

    fish = []
    for name, at, turn in (("Fish", (0.7, 0.3, 0.8), 0.5), ("Other fish", (-0.9, -0.5, 0.6), 2.0)):
        positions, _, triangles = shapes.ball(1.0, 64)
        c, s = np.cos(turn), np.sin(turn)
        turned = positions * [0.22, 0.06, 0.09] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        fish.append(Occluder(name, turned + at, triangles))
    hull = shapes.bowl("Hull", np.array([0.8, 0.35, 0.22]), np.array([-0.4, 0.7, 1.72]))
    deck, _, facets = shapes.box([1.7, 0.8, 0.02])
    fish.append(Occluder("Deck", deck + np.array([-0.4, 0.7, 1.74]), facets))
    receivers = (shapes.ground("Bed", 4.0, bed), hull)
    water = tests_waves.water(quads=128)
    sigma_a = np.array([0.35, 0.06, 0.03])
    return Scene(water, receivers, tuple(fish), (tests_waves.sun((0.75, 0.4, -0.7), LIGHT),), 1.333, sigma_a)


SMALL = (ball, slab, stone, ring, cup)
LARGE = (glass, mirror_room, lagoon)
