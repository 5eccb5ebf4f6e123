"""An image as the bytes of a PNG file with 16 bits a channel (w3.org/TR/png), for engines that read no OpenEXR."""

from __future__ import annotations

import struct
import zlib

import numpy as np

_UP = 2  # the filter: each line as its difference to the one above
_LEVEL = 6  # of zlib
WHITE = 65535


def encode_png(image, scale):
    """The bytes of `image` (H,W,3), row 0 at the bottom, with values up to `scale`, which is white.

    Values are linear: the pixel's number over 65535, times the scale, gives them back to half a step. ValueError for
    other shapes and for values outside 0 to scale, which a PNG cannot hold.
    """
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"image must have shape (height, width, 3), got {image.shape}")
    if not (image.min() >= 0 and image.max() <= scale):
        raise ValueError(f"image must lie in 0 to {scale:g}, got {image.min():g} to {image.max():g}")
    numbers = np.rint(image[::-1] * (WHITE / scale)).astype(">u2")
    height, width = numbers.shape[:2]
    lines = np.frombuffer(numbers.tobytes(), np.uint8).reshape(height, 6 * width)
    filtered = np.full((height, 6 * width + 1), _UP, np.uint8)
    filtered[0, 1:] = lines[0]
    filtered[1:, 1:] = lines[1:] - lines[:-1]
    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    data = zlib.compress(filtered.tobytes(), _LEVEL)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def _chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
