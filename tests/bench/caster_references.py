"""References of light over casters: Mitsuba's photons until two halves agree, kept in a folder that git ignores."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np

from dapple.kernels.chart.maps import Maps

from . import mitsuba_scene
from .mitsuba_light import LightTracer
from .reference_files import FOLDER

_ROUND = 2**23  # photons of each half at a time
_MOST = 12  # rounds
_ENOUGH = 5e-5, 0.02  # error and mean absolute error at which no further round is made


@dataclass(frozen=True)
class CasterReference:
    """maps: the Maps of all light; short: of the light that met no more than 6 specular surfaces; half: light (K,3) of
    one half of the photons, which is as far from `maps` as that is from the truth; lost: cause -> (3,) [W]."""

    maps: Maps
    short: Maps
    half: np.ndarray
    lost: dict
    photons: int


def of_scene(scene, texels):
    """The CasterReference of a Scene on Texels, one per receiver: from its file where the scene and the code are those
    of the file."""
    path = FOLDER / f"casters_{_digest(scene, texels)}.npz"
    if not path.exists():
        loaded = mitsuba_scene.load(scene)
        tracer = LightTracer(scene, loaded, texels[0].resolution)
        halves = tracer.throw(_ROUND, 1), tracer.throw(_ROUND, 2)
        rounds = 1
        while rounds < _MOST and not _good(_reference(texels, *_arrays(halves, rounds))):
            for number, half in enumerate(halves):
                half.add(tracer.throw(_ROUND, 2 * rounds + 1 + number))
            rounds += 1
        FOLDER.mkdir(exist_ok=True)
        flux, lost, photons = _arrays(halves, rounds)
        np.savez(path, flux=flux, lost=list(lost.values()), causes=list(lost), photons=photons)
    kept = np.load(path)
    lost = dict(zip(map(str, kept["causes"]), kept["lost"], strict=True))
    return _reference(texels, kept["flux"], lost, int(kept["photons"]))


def irradiance(texels, images):
    """Light (K,3) [W/m^2] on the texels of all receivers, of flux images (R,R,3) [W]."""
    parts = []
    for own, image in zip(texels, images, strict=True):
        owned = [own.gather(image[:, :, channel].ravel())[0] for channel in range(3)]
        parts.append(np.stack(owned, 1) / own.area[:, None])
    return np.concatenate(parts)


def _arrays(halves, rounds):
    """Flux (2 halves, all and short, receivers, R, R, 3), what is lost in the mean, and photons."""
    flux = np.stack([[half.maps, half.short] for half in halves]) / rounds
    lost = {cause: sum(half.lost[cause] for half in halves) / (2 * rounds) for cause in halves[0].lost}
    return flux, lost, sum(half.photons for half in halves)


def _reference(texels, flux, lost, photons):
    (first, first_short), (second, second_short) = ([irradiance(texels, kind) for kind in half] for half in flux)
    maps = Maps.of(texels, (first + second) / 2)
    short = Maps.of(texels, (first_short + second_short) / 2)
    return CasterReference(maps, short, first, lost, photons)


def _good(reference):
    maps, half = reference.maps, reference.half
    return maps.error(half) <= _ENOUGH[0] and maps.mean_error(half) <= _ENOUGH[1]


def _digest(scene, texels):
    digest = hashlib.sha256()
    _feed(digest, scene)
    digest.update(repr((texels[0].resolution, _ROUND, _MOST, _ENOUGH, mi.__version__)).encode())
    for name in ("mitsuba_scene.py", "mitsuba_light.py"):
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()[:16]


def _feed(digest, thing):
    """Feed a tree of dataclasses, tuples and arrays to a digest."""
    if is_dataclass(thing):
        for field in fields(thing):
            _feed(digest, getattr(thing, field.name))
    elif isinstance(thing, tuple):
        for part in thing:
            _feed(digest, part)
    else:
        digest.update(thing.tobytes() if isinstance(thing, np.ndarray) else repr(thing).encode())
