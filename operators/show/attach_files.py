"""The maps on disk as images of the file: found, loaded as sequences, and dropped when nothing shows them any more.

An image of ours has the custom property IMAGE, the name of its map: the receiver's, or one of its UDIM tiles'.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy

from ..errors import DappleError
from ..maps.write import folder_name
from ..read.tiles import of_tile, tile_name
from .map_nodes import Sequence

IMAGE = "dapple_map"


def find_maps(name, out_dir) -> dict[int | None, dict[int, Path]]:
    """The maps of a name in a folder: tile -> frame -> file; the tile is None where one map is all that there is.
    Raises DappleError if there is none."""
    receiver, own = of_tile(name)  # an object may be called as a tile is
    folder = Path(out_dir) / folder_name(receiver)
    tiles = _maps_in(folder) or _exported(receiver, Path(out_dir))
    if own:
        tiles = {None: tiles[own]} if own in tiles else {}
    if not tiles:
        raise DappleError(f"No lightmaps of '{name}' in {folder}: bake it first, or set the output folder.")
    return tiles


def _maps_in(folder):
    """The maps in a folder, as `find_maps`. OpenEXR as they are baked, else PNG as they are exported; of a bake in one
    map and one in tiles the later."""
    for ending in ("exr", "png"):
        tiles = {}
        for path in sorted(folder.glob(f"caustics_*.{ending}")):
            if match := re.fullmatch(rf"caustics_(?:(1\d{{3}})\.)?(\d+)\.{ending}", path.name):
                tiles.setdefault(match[1] and int(match[1]), {})[int(match[2])] = path
        if None in tiles and len(tiles) > 1:
            whole = tiles.pop(None)
            return {None: whole} if _written(whole) > max(map(_written, tiles.values())) else tiles
        if tiles:
            return tiles
    return {}


def _exported(name, out_dir):
    """The tiles' maps as exports leave them, in a folder each."""
    folders = {tile: out_dir / folder_name(tile_name(name, tile)) for tile in range(1001, 1100)}
    found = {tile: _maps_in(folder) for tile, folder in folders.items() if folder.is_dir()}
    return {tile: maps[None] for tile, maps in found.items() if None in maps}


def _written(files):
    return max(path.stat().st_mtime_ns for path in files.values())


def load(name, tiles) -> tuple[Sequence, ...]:
    """The Sequences of the maps of a name, by tile as `find_maps` gives them, read anew."""
    return tuple(
        _load(tile_name(name, tile) if tile else name, tile, tiles[tile]) for tile in sorted(tiles, key=_number)
    )


def _number(tile):
    return tile or 0


def _load(name, tile, files):
    first, last = min(files), max(files)
    scale = _scale(files[first])
    path = _blend_relative(files[first])
    image = next((image for image in bpy.data.images if image.get(IMAGE) == name), None)
    if image is None:
        image = bpy.data.images.load(path)
        image.name, image[IMAGE] = f"Dapple {name}", name
    # Setting path and source, even to what they were, makes Blender forget the pixels of an earlier bake.
    image.filepath = path
    image.source = "SEQUENCE" if len(files) > 1 else "FILE"
    image.colorspace_settings.name = "Non-Color"
    return Sequence(image, first, last, scale, tile)


def loaded(name) -> tuple[Sequence, ...]:
    """The Sequences of the maps of a name that the file's images show, as far as there are any on disk."""
    found = []
    for image in bpy.data.images:
        shown = image.get(IMAGE, "")
        tile = None if shown == name else of_tile(shown)[1]
        if shown == name or (tile and of_tile(shown)[0] == name):
            maps = _maps_in(Path(bpy.path.abspath(image.filepath)).parent)
            if files := maps.get(tile) or maps.get(None):
                found.append(_load(shown, tile, files))
    return tuple(sorted(found, key=lambda sequence: _number(sequence.tile)))


def remove_unused_images() -> None:
    """Drop the images of ours that nothing shows."""
    for image in [image for image in bpy.data.images if IMAGE in image and image.users == 0]:
        bpy.data.images.remove(image)


def _scale(path):
    """The irradiance that a value of 1 in a map stands for: of PNG what was written beside them."""
    if path.suffix != ".png":
        return 1.0
    told = path.parent / "sequence.json"
    try:
        return float(json.loads(told.read_text(encoding="utf-8"))["value_scale"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DappleError(f"{told} does not tell what the PNG beside it stand for ({error}); export again.") from error


def _blend_relative(path):
    """Write `path` as the .blend file would, so that a project can be moved; as it is where that cannot be."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path))
    except ValueError:  # another drive
        return str(path)
