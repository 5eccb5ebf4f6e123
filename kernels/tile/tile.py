"""A map that repeats without a seam, of water that does.

Water and receiver are one tile. The water is repeated as far as light from it can reach the tile, the receiver is made
wider by what the sun's disc spreads, and of its map the middle is kept: there all is as on a pool without an end.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..maps.texels import rasterise
from ..optics import cosine_refracted
from ..scene import Receiver, Solution, Sun
from ..status import counts
from .lattice import Lattice, repeated

_FLAT = 1e-4  # of a side: how far a receiver may be from a flat, level parallelogram
_LEAST = 4  # texels round the tile, at least
_MORE = 0.02  # of a tile, at least, round what reaches it
_SHAPE = "a tileable map needs one receiver: a level, flat four-sided tile whose UV map fills the square"
_ALONE = "what else stands in the scene: the water's light alone can be tiled"


def solve(solve_plain, scene, texels, settings):
    """The Solution of a Scene whose water is one tile, by `solve_plain(scene, texels, settings)`, for Texels of its one
    receiver. Raises ValueError for another receiver, for lamps other than suns, and for water that does not tile."""
    wide, pad = widened(scene, texels[0].resolution)
    chart = rasterise(wide.receivers[0], texels[0].resolution + 2 * pad, 0)
    return _cropped(solve_plain(wide, (chart,), settings), scene, pad)


def widened(scene, resolution):
    """(Scene, texels that its receiver is wider by on each side) that stand for a tile without an end."""
    if not all(isinstance(light, Sun) for light in scene.lights):
        raise ValueError("a tileable map needs parallel light: leave suns only, no other lamps")
    lattice = _tile(scene.receivers)
    own = lattice.coordinates(scene.water.positions)
    lands = [_displacements(scene, light, lattice) for light in scene.lights]
    depth = float(scene.water.positions[:, 2].max() - lattice.origin[2])
    spread = max((np.tan(light.angle) for light in scene.lights), default=0.0) * depth
    shortest = np.linalg.norm(lattice.sides, axis=1).min()
    pad = int(np.ceil(spread / shortest * resolution)) + _LEAST
    beside = pad / resolution
    swell = np.ptp(scene.water.positions[:, 2]) / shortest  # waves that shade each other stand no further off, or
    more = _MORE + swell * (1 + max((_slant(light) for light in scene.lights), default=0.0))
    low = -beside - more - np.max([shift.max(0) for shift in lands], axis=0)
    high = 1 + beside + more - np.min([shift.min(0) for shift in lands], axis=0)
    if np.ptp(own, axis=0).max() > 1.5:
        raise ValueError("the water is wider than the receiver: both must be one tile of the same size")
    water = repeated(scene.water, lattice, low, high)
    receiver = _wider(scene.receivers[0].name, lattice, beside)
    return replace(scene, water=water, receivers=(receiver,), occluders=(), casters=(), volume=None), pad


def _tile(receivers):
    """The Lattice of a scene's receivers. Raises ValueError unless there is one, and it is a tile."""
    if len(receivers) != 1:
        raise ValueError(_SHAPE)
    receiver = receivers[0]
    uv = receiver.uvs.reshape(-1, 2)
    corners = receiver.positions[receiver.triangles].reshape(-1, 3)
    fit, *_ = np.linalg.lstsq(np.column_stack([np.ones(len(uv)), uv]), corners, rcond=None)
    origin, sides = fit[0], fit[1:]
    size = np.linalg.norm(sides, axis=1).min()
    off = np.abs(origin + uv @ sides - corners).max()
    area = np.linalg.norm(np.cross(corners[1::3] - corners[::3], corners[2::3] - corners[::3]), axis=1).sum() / 2
    whole = abs(area / max(np.linalg.norm(np.cross(*sides)), np.finfo(float).tiny) - 1) < _FLAT
    if not whole or max(off, np.abs(sides[:, 2]).max()) > _FLAT * size or np.ptp(uv, axis=0).min() < 1 - _FLAT:
        raise ValueError(_SHAPE)
    return Lattice(origin, sides * [1, 1, 0])


def _wider(name, lattice, beside):
    """The tile as a Receiver, by `beside` of a side wider all round, seen from above."""
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    place = lattice.origin + (uv * (1 + 2 * beside) - beside) @ lattice.sides
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    if np.cross(*lattice.sides)[2] < 0:
        triangles = triangles[:, ::-1]
    return Receiver(name, place, triangles, uv[triangles])


def _displacements(scene, sun, lattice):
    """By how many tiles (V,2) light of a sun is displaced from each of the water's vertices to the receiver."""
    normals = np.zeros_like(scene.water.positions)
    np.add.at(normals, scene.water.triangles, scene.water.normals[scene.water.normal_triangles])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    cos_i = np.maximum(-normals @ sun.direction, 0)
    eta = 1 + 0.9 * (scene.eta - 1)  # dispersed light is bent by less
    bent = sun.direction / eta + (cos_i / eta - cosine_refracted(cos_i, eta))[:, None] * normals
    depth = scene.water.positions[:, 2] - lattice.origin[2]
    return lattice.coordinates(lattice.origin + bent * (depth / np.maximum(-bent[:, 2], 1e-3))[:, None])


def _slant(sun):
    """How far a sun's light goes sideways, per metre down."""
    return np.linalg.norm(sun.direction[:2]) / max(-sun.direction[2], 1e-3)


def _cropped(wide, scene, pad):
    """The Solution of the tile, from that of a wider one."""
    inner = slice(pad, -pad)
    image, status = wide.images[0][inner, inner], wide.status[0][inner, inner]
    work, sides = wide.diagnostics, _tile(scene.receivers).sides
    area = np.linalg.norm(np.cross(*sides))
    came = sum(light.irradiance * max(-light.direction[2], 0) for light in scene.lights) * area
    received = image.mean((0, 1)) / work.map_scale * area
    left_out = [*work.left_out, *([_ALONE] if scene.occluders or scene.casters else [])]
    work = replace(
        work,
        flux_in=came,
        flux_received={scene.receivers[0].name: received},
        flux_lost={"reflected_or_absorbed": came - received},
        texels=counts(status),
        left_out=left_out,
    )
    return Solution((image,), (status,), work)
