"""Dispersion: an index of refraction for each of red, green and blue, in water and glass, and one solution for each.

Cauchy's n = A + B / lambda^2 through n_d and the Abbe number V_d = (n_d - 1) / (n_F - n_C) [1]. Water at 20 degrees has
n_d = 1.3330 and V_d = 55.7 [2]. A channel is light of one wavelength, the dominant one of its Rec. 709 primary [3].

[1] Born & Wolf, Principles of Optics, 2.3.4 and 4.7.
[2] Daimon & Masumura 2007, Measurement of the refractive index of distilled water, Applied Optics 46, 3811.
[3] ITU-R BT.709 primaries, against D65.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from .casters import Glass
from .scene import Diagnostics, Solution, Sun
from .status import Status, counts

_D, _F, _C = 587.56, 486.13, 656.27  # nm: Fraunhofer's lines
_SHARE = re.compile(r"[\d.]+%")  # in which sentences on one thing differ from channel to channel
_CHANNELS = np.array([611.4, 549.1, 464.2])  # nm


def etas(eta, abbe):
    """Indices (3,) in red, green and blue of a medium with index eta at the d line and Abbe number abbe; all are eta
    where abbe is 0. Raises ValueError for other numbers below 1, which no matter has."""
    if not abbe:
        return np.full(3, float(eta))
    if not abbe >= 1:
        raise ValueError(f"dispersion must be 0 or an Abbe number of at least 1, got {abbe}")
    return eta + (eta - 1) / abbe * (_CHANNELS**-2.0 - _D**-2) / (_F**-2 - _C**-2)


def solve_channels(solve, scene, texels, settings):
    """The Solution by `solve` of a Scene whose water and glass have the indices of `etas`: one for all channels that
    they bend alike, summed. Channels in which no light shines are not solved."""
    indices = _indices(scene, settings.dispersion)
    power = [light.irradiance if isinstance(light, Sun) else light.intensity for light in scene.lights]
    lit = np.sum(power, axis=0) > 0 if power else np.zeros(3, bool)
    rows, of = np.unique(indices[lit], axis=0, return_inverse=True)
    groups = [np.isin(np.arange(3), np.flatnonzero(lit)[of.reshape(-1) == k]) for k in range(len(rows))]
    if len(groups) < 2:
        return solve(_with_indices(scene, rows[0]) if groups else scene, texels, settings)
    return _sum([solve(_only(scene, row, own), texels, settings) for row, own in zip(rows, groups, strict=True)])


def _indices(scene, abbe):
    """Indices (3, 1 + casters) in each channel, of the water, if there is any, and of what casters are of; 0 for
    mirrors."""
    own = [etas(scene.eta, abbe if len(scene.water.triangles) else 0.0)]
    for caster in scene.casters:
        glass = caster.material
        own.append(etas(glass.eta, glass.abbe or abbe) if isinstance(glass, Glass) else np.zeros(3))
    return np.stack(own, 1)


def _with_indices(scene, indices):
    """The scene with indices (1 + casters,), as `_indices` has them."""
    casters = [
        replace(caster, material=replace(caster.material, eta=float(eta), abbe=0.0)) if eta else caster
        for caster, eta in zip(scene.casters, indices[1:], strict=True)
    ]
    return replace(scene, eta=float(indices[0]), casters=tuple(casters))


def _only(scene, indices, channels):
    """The scene with some indices (1 + casters,) and the light of some channels (3,) bool."""
    lights = []
    for light in scene.lights:
        name = "irradiance" if isinstance(light, Sun) else "intensity"
        lights.append(replace(light, **{name: np.where(channels, getattr(light, name), 0.0)}))
    return replace(_with_indices(scene, indices), lights=tuple(lights))


def _sum(solutions):
    """One Solution of those of single channels."""
    images = tuple(sum(parts) for parts in zip(*(s.images for s in solutions), strict=True))
    status = tuple(_status(np.stack(parts)) for parts in zip(*(s.status for s in solutions), strict=True))
    books = [s.diagnostics for s in solutions]
    work = Diagnostics(books[0].method, books[0].reason)
    for field in ("seconds", "flux_received", "flux_lost", "paths"):
        setattr(work, field, _added([getattr(b, field) for b in books]))
    work.flux_in = sum(b.flux_in for b in books)
    work.texels = counts(np.concatenate([np.zeros(0, np.uint8), *(s.ravel() for s in status)]))
    errors = [b.estimated_error for b in books if b.estimated_error is not None]
    work.estimated_error = max(errors) if errors else None
    said = {_SHARE.sub("", sentence): sentence for b in books for sentence in b.left_out}
    work.left_out = list(said.values())
    return Solution(images, status, work)


def _status(codes):
    """Status (H,W) of texels by codes (C,H,W) of channels: incomplete where one proves it so, else lit where one is."""
    merged = codes[0]
    for code in (Status.LIT, Status.INCOMPLETE):
        merged = np.where((codes == code).any(0), np.uint8(code), merged)
    return merged


def _added(dictionaries):
    """The sums of values under the same keys."""
    keys = dict.fromkeys(key for d in dictionaries for key in d)
    return {key: sum(d[key] for d in dictionaries if key in d) for key in keys}
