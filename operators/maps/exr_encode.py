"""A map as the bytes of an OpenEXR file: scan lines, ZIP, half or full floats.

The layout is that of openexr.com, "OpenEXR File Layout"; ZIP is its lossless compression of 16 lines at a time: even
bytes before odd ones, each as its difference to the one before, deflated. Written here, since Blender writes half
floats only by a scene's render settings; the same map gives the same bytes anywhere.
"""

from __future__ import annotations

import struct
import zlib

import numpy as np

_LINES = 16  # of a chunk
_LEVEL = 4  # of zlib, as OpenEXR itself takes
_ZIP, _HALF, _FLOAT = 3, 1, 2
_ROUNDING = 2.0**-22  # relative, squared: half floats have 11 bits, so that values in their range are good to 2^-11


def encode(image, full=False):
    """The bytes of `image` (H,W,3), row 0 at the bottom, as linear RGB; full: float32, else half where that will do.

    Half floats reach up to 65504 and get coarse below 6e-5: where they would cost more than their rounding, squared and
    relative to the mean square, the image is kept in float32 all the same. ValueError for other shapes and for values
    that are not finite.
    """
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"image must have shape (height, width, 3), got {image.shape}")
    if not np.isfinite(image).all():
        raise ValueError(f"image must be finite, {np.count_nonzero(~np.isfinite(image))} values of it are not")
    pixels = image.astype("<f4") if full or not fits_half(image) else image.astype("<f2")
    lines = pixels[::-1, :, ::-1].transpose(0, 2, 1)  # from the top; blue, green, red, by the alphabet
    head = _header(*lines.shape[::2], _HALF if pixels.itemsize == 2 else _FLOAT)
    chunks = [_chunk(y, lines[y : y + _LINES]) for y in range(0, len(lines), _LINES)]
    start = len(head) + 8 * len(chunks)
    offsets = start + np.cumsum([0, *map(len, chunks[:-1])])
    return b"".join([head, offsets.astype("<i8").tobytes(), *chunks])


def fits_half(image):
    """Whether half floats keep an image to their rounding."""
    with np.errstate(over="ignore"):
        half = image.astype(np.float16).astype(np.float64)
    return bool(np.isfinite(half).all() and np.sum((half - image) ** 2) <= _ROUNDING * np.sum(np.square(image)))


def _header(height, width, kind):
    """Magic, version and the attributes of an image."""
    channels = b"".join(name + b"\0" + struct.pack("<iiii", kind, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    attributes = (
        (b"channels", b"chlist", channels),
        (b"compression", b"compression", bytes([_ZIP])),
        (b"dataWindow", b"box2i", window),
        (b"displayWindow", b"box2i", window),
        (b"lineOrder", b"lineOrder", b"\0"),
        (b"pixelAspectRatio", b"float", struct.pack("<f", 1.0)),
        (b"screenWindowCenter", b"v2f", struct.pack("<ff", 0.0, 0.0)),
        (b"screenWindowWidth", b"float", struct.pack("<f", 1.0)),
    )
    body = b"".join(n + b"\0" + kind + b"\0" + struct.pack("<i", len(v)) + v for n, kind, v in attributes)
    return b"\x76\x2f\x31\x01" + struct.pack("<i", 2) + body + b"\0"


def _chunk(y, lines):
    """One chunk of lines (n,3,W) from line y on; as it is where deflating does not make it smaller."""
    raw = np.frombuffer(lines.tobytes(), np.uint8)
    ordered = np.concatenate([raw[::2], raw[1::2]])
    steps = np.diff(ordered, prepend=np.uint8(128)) + np.uint8(128)
    packed = zlib.compress(steps.tobytes(), _LEVEL)
    data = packed if len(packed) < len(raw) else raw.tobytes()
    return struct.pack("<ii", y, len(data)) + data
