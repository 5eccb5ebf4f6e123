"""Area lamps as pieces, each of which shines from its middle, with the blur of its size.

All methods know light that comes from one point, and blur by an ellipse on each texel what comes from round it
(`disc/moments_of_lamps.py`). That ellipse is one of still water and of small sizes; so a lamp that is wide as the water
and the floor see it is cut in pieces, evenly and in every frame alike. Their pictures lie apart and are added up.
Over casters there is no blur, and more pieces stand for what is between them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .scene import Area, Piece
from .under_water import under_water

_GOLDEN = (np.sqrt(5) - 1) / 2
_MOST = 64  # pieces
_SHARE = 0.6  # of the tolerance
# Measured on five_sines, a lamp of 0.4 to 1 m at 1 to 2 m: mean squared error of one piece over the mean square of the
# light, at most, and for each texel that half of the lamp's picture is wide; two along a side had 0.3 of it, three a
# sixth.
_WIDE_ERROR, _TEXEL_ERROR = 5e-3, 1e-3
_NEAR = 0.5  # of the longer half axis: from which distance on a lamp is as near as can be
# Of half a piece over the way on which its light changes, to the fourth power, as an error: of the tolerance still
# water, under a spread of 15 to 180 degrees, had 0.5 at most.
_EVEN = 0.6
_CROSSING = 4  # pieces along a side of a lamp that reaches into the water
_SAMPLES = 1 << 12
_SIDE = 2 / np.sqrt(3)  # half axis of the ellipse with the second moments of a rectangle, over half its side


def among(light):
    """Of how many pieces of equal power a light is one."""
    return light.among if isinstance(light, Piece) else 1


def lamp_of(light):
    """The name of the lamp that a light is of."""
    return light.lamp if isinstance(light, Piece) else light.name


def cut(scene, texels, tolerance):
    """The Scene with Pieces in the place of each Area, as many as the tolerance asks for on its Texels, and sentences
    on what they leave out: what is between them, and those under the water."""
    lights, sentences = [], []
    for light in scene.lights:
        if not isinstance(light, Area):
            lights.append(light)
            continue
        counts, enough = _counts(scene, texels, light, tolerance)
        made = pieces(light, counts)
        if not enough:
            sentences.append(f"what is between {len(made)} pieces of the lamp '{light.name}', which shines narrowly")
        low = _reaches(scene.water, light)
        above = [piece for piece in made if not (low and under_water(scene.water, piece.position))]
        if len(above) < len(made):
            sentences.append(f"the part of the lamp '{light.name}' under the water: {1 - len(above) / len(made):.0%}")
        lights += above
    return replace(scene, lights=tuple(lights)), sentences


def _counts(scene, texels, area, tolerance):
    """How many pieces (2,) along both half axes, and whether they are enough."""
    positions = scene.water.positions
    if not len(positions):
        return (1, 1), True
    half = np.linalg.norm(area.half_axes, axis=1)
    away = max(np.sqrt(((positions - area.position) ** 2).sum(1).min()), _NEAR * half.max())
    error = np.minimum(_WIDE_ERROR, _TEXEL_ERROR * half / away * _depth(scene, texels))
    counts = np.ceil(np.sqrt(error / (_SHARE * tolerance)))
    even = away * min(np.tan(area.spread / 2), 1.0)  # over which a piece's light changes, without any waves
    counts = np.maximum(counts, np.ceil(_EVEN * half / even * tolerance**-0.25))
    if _reaches(scene.water, area):
        counts = np.maximum(counts, _CROSSING)
    least = np.clip(counts, 1, _MOST).astype(int)
    while least.prod() > _MOST:
        least[np.argmax(least)] -= 1
    return tuple(least.tolist()), bool(least.prod() >= counts.prod())


def _depth(scene, texels):
    """How deep below the water the texels lie, in texels, root mean square, as light goes there."""
    level = scene.water.positions[:, 2].mean()
    deep = np.concatenate([np.zeros(0), *((t.positions[:: len(t.texel) // _SAMPLES + 1, 2] - level) for t in texels)])
    area = np.concatenate([np.zeros(0), *(t.area[:: len(t.texel) // _SAMPLES + 1] for t in texels)])
    return float(np.sqrt(np.mean(deep**2 / np.maximum(area, np.finfo(float).tiny)))) / scene.eta if len(deep) else 0.0


def _reaches(water, area):
    """Whether a lamp reaches as low as the highest of the water."""
    return area.position[2] - np.abs(area.half_axes[:, 2]).sum() < water.positions[:, 2].max(initial=-np.inf)


def pieces(area, counts):
    """The Pieces of an Area: counts[0] by counts[1] of a rectangle, as many along a sunflower's spiral of an ellipse.
    One after the other lie apart: every other one makes a half of the lamp."""
    half_axes, many = np.asarray(area.half_axes, float), int(np.prod(counts))
    if area.round:
        at = np.arange(many)
        ring, turn = np.sqrt(at / many), 2 * np.pi * _GOLDEN * at  # with the pieces' own, the moments of the ellipse
        places = np.stack([ring * np.cos(turn), ring * np.sin(turn)], 1)
        places -= places.mean(0)
        own = half_axes / np.sqrt(many)
    else:
        u, v = ((2 * np.arange(n) + 1) / n - 1 for n in counts)
        places = np.stack(np.meshgrid(u, v), 2)
        places[1::2] = places[1::2, ::-1].copy()  # to and fro
        places, own = places.reshape(-1, 2), _SIDE * half_axes / np.reshape(counts, (2, 1))
    position, intensity = np.asarray(area.position, float), np.asarray(area.intensity, float) / many
    cone = _frame(half_axes), area.spread / 2, 1.0
    made = Piece(area.name, position, intensity, 0.0, *cone, area.name, many, own, area.round)
    return [
        replace(made, name=f"{area.name}, piece {k + 1}" if many > 1 else area.name, position=position + place)
        for k, place in enumerate(places @ half_axes)
    ]


def _frame(half_axes):
    """Frame (3,3) of a lamp: rows across it, and along its axis."""
    axis, across = np.cross(*half_axes), half_axes[0] / np.linalg.norm(half_axes[0])
    axis /= np.linalg.norm(axis)
    return np.stack([across, np.cross(axis, across), axis])
