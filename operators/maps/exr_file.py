"""Whether an OpenEXR file is whole: a disk that fills up leaves files that open, and end too soon.

The file is a header of attributes, a table of the offsets of its chunks of pixels, and the chunks, each with its size
(openexr.com, "OpenEXR File Layout").
"""

from __future__ import annotations

import os
import struct

_MAGIC = b"\x76\x2f\x31\x01"


def is_whole(path):
    """Whether the single-part scan-line file at `path` holds every chunk that its table names, to the last byte."""
    try:
        with open(path, "rb") as file:
            return _holds_all(file, os.fstat(file.fileno()).st_size)
    except (OSError, struct.error):  # not there, or shorter than its own header
        return False


def _holds_all(file, length):
    """Whether the chunks of an open file end within its length."""
    if file.read(8)[:4] != _MAGIC:
        return False
    while _text(file):
        _text(file)
        _skip(file, struct.unpack("<i", file.read(4))[0])
    start = file.tell()
    (first,) = struct.unpack("<q", file.read(8))
    if not start < first < length:
        return False
    file.seek(start)
    offsets = struct.unpack(f"<{(first - start) // 8}q", file.read((first - start) // 8 * 8))
    if min(offsets) < first:
        return False
    file.seek(max(offsets))
    _, size = struct.unpack("<ii", file.read(8))
    return max(offsets) + 8 + size <= length


def _text(file):
    """The bytes up to the next zero byte."""
    text = bytearray()
    while (byte := file.read(1)) not in (b"\0", b""):
        text += byte
    return text


def _skip(file, size):
    """Pass over the value of an attribute."""
    if size < 0:
        raise struct.error("negative size")
    file.seek(size, os.SEEK_CUR)
