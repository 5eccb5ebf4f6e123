"""Baked maps read back, by Blender's own reader."""

from __future__ import annotations

import bpy
import numpy as np

from ..errors import DappleError
from .exr_file import is_whole


def read_map(path):
    """The pixels (H,W,3) float32 of an OpenEXR map, row 0 at v = 0; raises DappleError where it is not there or cut
    short."""
    if not is_whole(path):
        raise DappleError(f"The map {path} is not on disk or not whole; bake its frame again.")
    image = bpy.data.images.load(str(path))
    try:
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[..., :3]


def reduced(image, size):
    """An image (S,S,3) as (size, size, 3), each texel the mean of those that it replaces, so that no light is lost.

    Raises DappleError for a size that does not divide S.
    """
    side = image.shape[0]
    if not 1 <= size <= side or side % size:
        fitting = [side // k for k in range(1, side + 1) if side % k == 0 and side // k >= 16]
        raise DappleError(
            f"Maps of {side} texels cannot be reduced to {size}; set one of {', '.join(map(str, fitting))}."
        )
    part = side // size
    return image.reshape(size, part, size, part, -1).mean(axis=(1, 3))
