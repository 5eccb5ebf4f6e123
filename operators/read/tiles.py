"""UDIM tiles: the names of their maps, and of the files."""

from __future__ import annotations

import re

_NAME = re.compile(r"(.+) \[(1\d{3})\]", re.DOTALL)


def tile_name(name, tile):
    """The name of the map of a tile, 1001 and so on, of a receiver."""
    return f"{name} [{tile}]"


def of_tile(name):
    """(receiver, tile) of the name of a map; (name, None) of one that is all that its receiver has."""
    found = _NAME.fullmatch(name)
    return (found[1], int(found[2])) if found else (name, None)
