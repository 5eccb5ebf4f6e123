"""The maps of a frame on disk."""

from __future__ import annotations

from ..errors import DappleError
from ..read.digest import checksum
from .write import disk_sentence, map_path, write_file

_GONE = "The output folder {} is gone; connect its drive and bake again. The finished frames are kept."


def write_maps(folder, number, scene, files):
    """Write the maps of a frame, the bytes of one for each receiver of its Scene.

    Returns files and checksums, each by receiver: where they lie in the folder, and what is in them. Raises DappleError
    where the disk does not take them.
    """
    return _written(folder, number, dict(zip((receiver.name for receiver in scene.receivers), files, strict=True)))


def copy_maps(folder, number, files):
    """Write maps that lie in the same folder, {receiver: path in it}, as those of another frame; returns as
    `write_maps`."""
    contents = {}
    for name, file in files.items():
        try:
            contents[name] = (folder / file).read_bytes()
        except OSError as error:
            raise DappleError(disk_sentence(folder / file, error)) from error
    return _written(folder, number, contents)


def _written(folder, number, contents):
    if not folder.is_dir():  # it would be made anew where the drive was mounted
        raise DappleError(_GONE.format(folder))
    paths = {name: map_path(folder, name, number) for name in contents}
    for name, path in paths.items():
        write_file(path, contents[name])
    return {
        "files": {name: path.relative_to(folder).as_posix() for name, path in paths.items()},
        "checksums": {name: checksum(content) for name, content in contents.items()},
    }
