"""Images and records on disk: whole or not at all.

A file is written beside its place under a hidden name, synced, and then put in place by one rename. A write that fails
leaves no file of its own, and the file of an earlier bake as it was.
"""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import zlib
from pathlib import Path

import bpy
import numpy as np

from ..bake.turns import clear_up, partial_path
from ..errors import DappleError
from ..read.tiles import of_tile
from .exr_encode import encode

_FORBIDDEN = frozenset('<>:"/\\|?*')
_GONE = {getattr(errno, name, None) for name in ("ENOENT", "ENODEV", "ENXIO", "ESTALE", "ENOTCONN", "EHOSTDOWN")}
_DEVICES = frozenset(["CON", "PRN", "AUX", "NUL"] + [f"{port}{n}" for port in ("COM", "LPT") for n in range(1, 10)])


def folder_name(object_name):
    """The folder of an object's maps: its name, or where no file system would take that, a cleaned one with a mark.

    The mark is a checksum of the name, so that objects "a/b" and "a:b" do not share a folder.
    """
    legal = not any(c in _FORBIDDEN or ord(c) < 32 for c in object_name) and object_name[-1:] not in (".", " ", "")
    if legal and object_name.split(".")[0].upper() not in _DEVICES:
        return object_name
    return f"{bpy.path.clean_name(object_name)}-{zlib.crc32(object_name.encode()):08x}"


def map_path(out, object_name, frame):
    """Where the lightmap of one object, or of one of its UDIM tiles, and one frame lies. The frame comes last, where
    Blender looks for it in sequences."""
    receiver, tile = of_tile(object_name)
    number = f"{tile}.{frame:04d}" if tile else f"{frame:04d}"
    return Path(out) / folder_name(receiver) / f"caustics_{number}.exr"


def write_exr(path, image, full=False):
    """Write image (H,W,3), row 0 at v = 0, as linear RGB: half floats, or float32 if `full`; see `exr_encode.encode`.

    Raises DappleError where the disk does not take it, ValueError for another shape and for values that are not finite.
    """
    write_file(path, encode(np.asarray(image), full))


def write_file(path, content):
    """Write bytes; raises DappleError where the disk does not take them."""
    with _put_in_place(Path(path)) as partial:
        partial.write_bytes(content)


def write_json(path, record):
    """Write a dict; arrays become lists, numbers that are not finite null. Raises DappleError as write_exr does."""
    write_text(path, json.dumps(plain(record), indent=1, allow_nan=False) + "\n")


def write_text(path, text):
    """Write text in UTF-8; raises DappleError where the disk does not take it."""
    write_file(path, text.encode())


def check_folder(folder):
    """Make `folder` and raise DappleError if it takes no file: better known before the work than after it. Clears up
    what bakes that were killed there left behind."""
    trial = Path(folder) / ".trial"
    try:
        trial.parent.mkdir(parents=True, exist_ok=True)
        trial.touch()
        trial.unlink(missing_ok=True)
    except OSError as error:
        raise DappleError(disk_sentence(folder, error)) from error
    clear_up(folder)


@contextlib.contextmanager
def _put_in_place(path):
    """Give a hidden name beside `path` to write to, and rename it to `path` once it is safely on the disk."""
    partial = partial_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield partial
        with partial.open("rb+") as written:
            os.fsync(written.fileno())
        os.replace(partial, path)
    except OSError as error:
        raise DappleError(disk_sentence(path, error)) from error
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()


def disk_sentence(path, error):
    """What to tell the user of an OSError at `path`."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        why = "no space left on the disk; free some space or choose another folder"
    elif error.errno == errno.EFBIG:
        why = "the system allows no larger file; raise the limit or choose another folder"
    elif error.errno in (errno.EACCES, errno.EPERM, errno.EROFS):
        why = "writing is not allowed there; change the folder's permissions or choose another folder"
    elif error.errno in (errno.ENOTDIR, errno.EEXIST):
        why = "a part of this path is a file, not a folder; choose another folder"
    elif error.errno in _GONE:
        why = "the drive or folder is not there; connect it, or choose another folder"
    else:
        why = f"{error.strerror or error}; choose another folder"
    return f"Could not write {path}: {why}."


def plain(value):
    """What json can hold of dicts, sequences, arrays, paths and numbers."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
