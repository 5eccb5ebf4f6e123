"""Single rays over casters, and where the closed forms of geometric optics send them; shared by the tests."""

import numpy as np
from casters import no_water
from waves import floor

from dapple.kernels.scene import Scene
from dapple.kernels.trace.codes import Codes
from dapple.kernels.trace.follow import Follower, Rays
from dapple.kernels.trace.surfaces import Surfaces


def scene(*casters, over=None, receivers=None, occluders=()):
    receivers = (floor(side=40.0, z=-20.0),) if receivers is None else receivers
    return Scene(over or no_water(), receivers, occluders, (), casters=casters)


def follow(where, origins, directions, word=None, bounces=6, mask=0, box=None, faint=1e-6):
    """All that ends, as one Rays, and on what."""
    surfaces = Surfaces(where, np.ones(3))
    directions = np.array(directions, float).T
    rays = Rays.of(np.array(origins, float).T, directions / np.linalg.norm(directions, axis=0), len(surfaces.sigma_a))
    rays.state = rays.state + surfaces.crossings.state(mask)
    codes = None if word is None else Codes([word])
    found = list(Follower(surfaces, bounces, faint, box).ends(rays, codes))
    columns = zip(*(vars(ended).values() for ended, _ in found), strict=True)
    ended = Rays(*(np.concatenate(column, axis=-1) for column in columns))
    return ended, np.concatenate([end for _, end in found])


def at_height(rays, z):
    return (rays.origin + (z - rays.origin[2]) / rays.direction[2] * rays.direction)[:2]


def through_a_ball(b, eta, plane):
    """Where light along -z, b from the axis of a unit ball, comes to z = plane: at which distance, signed."""
    i, t = np.arcsin(b), np.arcsin(b / eta)
    leaves = (np.pi / 2 - i) - (np.pi - 2 * t)  # from the x axis: the chord spans pi - 2 t
    return np.cos(leaves) - np.tan(2 * (i - t)) * (np.sin(leaves) - plane)
