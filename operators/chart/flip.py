"""FLIP of the largest map, by its authors' own code where that is installed: a development dependency."""

from __future__ import annotations

import numpy as np

NAME = "flip-evaluator"
MISSING = f"FLIP is left out: the Python package {NAME} is not installed here"


def flip():
    """A function of Texels and of true and found light (K,3), or None where the package is not installed.

    It returns the mean HDR-FLIP (Andersson et al. 2021) over the largest receiver's area.
    """
    try:
        import flip_evaluator
    except ImportError:
        return None

    def mean(texels, truth, found):
        largest = int(np.argmax([own.area.sum() for own in texels]))
        own, start = texels[largest], sum(len(t.texel) for t in texels[:largest])
        part = slice(start, start + len(own.texel))
        pair = [own.image(np.maximum(light[part], 0)).astype(np.float32) for light in (truth, found)]
        picture, _, _ = flip_evaluator.evaluate(*pair, "HDR", applyMagma=False)
        return float(np.average(picture.reshape(-1)[own.texel], weights=own.area))

    return mean
