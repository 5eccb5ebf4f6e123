"""From what a method found at the texels to what it answers: images, status and the books, alike for all methods."""

from __future__ import annotations

import numpy as np

from .scene import Solution
from .status import Status, counts


def check_texels(scene, texels):
    """Raise ValueError unless there is one Texels per receiver, all of one resolution."""
    if len(texels) != len(scene.receivers):
        raise ValueError(f"texels must have one entry per receiver ({len(scene.receivers)}), got {len(texels)}")
    if len({t.resolution for t in texels}) > 1:
        raise ValueError(f"texels must have one resolution, got {[t.resolution for t in texels]}")


def answer(scene, texels, irradiance, status, work):
    """The Solution for irradiance (K,3) [W/m^2] and status (K,) at the texels of all receivers, in their order.

    Books the flux that was received and the texels per status in the Diagnostics `work`.
    """
    images, codes = [], []
    cuts = np.cumsum([len(t.texel) for t in texels])[:-1]
    parts = zip(scene.receivers, texels, np.split(irradiance, cuts), np.split(status, cuts), strict=True)
    for receiver, own, light, code in parts:
        images.append(own.image(light))
        work.flux_received[receiver.name] = own.area @ light
        flat = np.full(own.resolution**2, Status.EMPTY, np.uint8)
        flat[own.texel] = code
        codes.append(flat.reshape(own.resolution, own.resolution))
    work.texels = counts(np.asarray(status, np.uint8))
    return Solution(tuple(images), tuple(codes), work)


def book(work, lost, met, share=1.0):
    """Add a `share` of {cause: (3,) W} lost and of what met the water (3,) to the books."""
    work.flux_in = work.flux_in + share * met
    for cause, watts in lost.items():
        work.flux_lost[cause] = work.flux_lost.get(cause, np.zeros(3)) + share * watts
