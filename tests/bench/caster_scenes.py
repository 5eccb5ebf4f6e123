"""The scenes of one caster on which light is measured, made of arrays, and the names of the sample .blend files."""

from __future__ import annotations

import numpy as np
import waves as tests_waves
from casters import no_water

from dapple.kernels.casters import Glass, Mirror
from dapple.kernels.scene import Scene

from . import caster_shapes as shapes

SUN = (0.5, 0.22, -1.0)
CROWN = Glass(1.5)
GREEN = Glass(1.52, np.array([6.0, 1.0, 4.0]))
DIAMOND = Glass(2.417)
SILVER = Mirror(np.full(3, 0.95), np.ones(3))
LIGHT = np.array([3.0, 2.9, 2.7])


def on_table(*casters, side=1.0, direction=SUN, lights=None):
    """A Scene of casters over a square table round the origin under a sun."""
    lights = (tests_waves.sun(direction, LIGHT),) if lights is None else lights
    return Scene(no_water(), (tests_waves.floor(side),), (), lights, casters=casters)


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


SMALL = (ball, slab, stone, ring, cup)
SAMPLES = ("glass", "mirror_room", "lagoon")
