"""A short name for whatever a map follows from: equal inputs have equal names, others have not."""

from __future__ import annotations

import functools
import hashlib
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

_ROOT = Path(__file__).resolve().parents[2]


def digest(*things):
    """32 hexadecimal digits that name the values of dataclasses, sequences, dicts, arrays and plain values.

    Raises TypeError for what else there is: it may be equal and look different, or the other way round.
    """
    state = hashlib.blake2b(digest_size=16)
    _feed(state, things)
    return state.hexdigest()


def checksum(content):
    """The same of the bytes of a file."""
    return hashlib.blake2b(content, digest_size=16).hexdigest()


@functools.cache
def code():
    """Names this very version of Dapple and of numpy: by its sources, so that it holds while they are worked on too."""
    paths = sorted(path for layer in ("kernels", "operators") for path in (_ROOT / layer).rglob("*.py"))
    return digest(np.__version__, *(path.read_bytes() for path in paths))


def _feed(state, thing):
    """Put a value into a hash, with its type and its length, so that no two things run into each other."""
    state.update(type(thing).__name__.encode() + b":")
    if is_dataclass(thing):
        for one in fields(thing):
            _feed(state, getattr(thing, one.name))
    elif isinstance(thing, dict):
        _feed(state, list(thing.items()))
    elif isinstance(thing, (tuple, list)):
        state.update(f"{len(thing)}:".encode())
        for one in thing:
            _feed(state, one)
    elif isinstance(thing, np.ndarray) and not thing.dtype.hasobject:
        state.update(f"{thing.dtype.str}{thing.shape}:".encode())
        state.update(np.ascontiguousarray(thing).data)
    elif isinstance(thing, (str, bytes)):
        content = thing.encode() if isinstance(thing, str) else thing
        state.update(f"{len(content)}:".encode() + content)
    elif thing is None or isinstance(thing, (bool, int, float, np.generic)):
        state.update(repr(thing).encode())
    else:
        raise TypeError(f"digest knows no {type(thing).__name__}")
