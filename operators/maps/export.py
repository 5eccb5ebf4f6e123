"""What others make of baked maps: loops, PNG, flipbook atlases, and cookies for lights.

All is read from the maps on disk and written beside them, in <maps>/export; nothing is solved. A file <form>.json tells
with each what the numbers are, and bake.json tells what there is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..bake.record import note_export, recorded_frames
from ..errors import DappleError
from .exr_encode import encode
from .loop import Loop, as_they_are, looped
from .png_encode import encode_png
from .read_map import read_map, reduced
from .write import check_folder, folder_name, write_file, write_json

FORMS = ("sequence", "atlas", "cookie")
MOST_SIDE = 16384  # texels of an atlas: more than engines and graphics cards take


@dataclass(frozen=True)
class Export:
    """What to make: form, one of FORMS; png: 16-bit PNG in place of OpenEXR; loop: None, or how many frames to blend, 0
    to find the period or else choose; size: texels along each side of a frame, 0 as baked; frames and receivers, all
    that are baked where empty; out: a folder, beside the maps where None."""

    form: str = "sequence"
    png: bool = False
    loop: int | None = None
    size: int = 0
    frames: tuple[int, ...] = ()
    receivers: tuple[str, ...] = ()
    out: Path | None = None


def export(context, request, wish: Export):
    """Yield a sentence for each receiver whose files are written. request: of the bake whose maps are taken; its
    objects are read only to find a loop. Raises DappleError, before anything is written, for what is not there."""
    frames = recorded_frames(request.out)
    numbers = tuple(n for n in sorted(frames) if not wish.frames or n in wish.frames)
    missing = sorted(set(wish.frames) - set(numbers))
    if missing or not numbers:
        raise DappleError(f"Frame {(missing or ['?'])[0]} is not in {request.out / 'bake.json'}: bake it first.")
    names = wish.receivers or tuple(frames[numbers[0]]["files"])
    for name in names:
        for number in numbers:
            if name not in frames[number]["files"]:
                raise DappleError(f"Frame {number} has no map of '{name}': bake it with that receiver.")
    loop = as_they_are(numbers) if wish.loop is None else looped(context, request, numbers, wish.loop)
    out, render = wish.out or request.out / "export", context.scene.render
    if out.resolve() == request.out.resolve():
        raise DappleError(f"{out} holds the baked maps themselves; choose another folder.")
    check_folder(out)
    for name in names:
        paths = {number: request.out / frames[number]["files"][name] for number in numbers}
        said = _write(out, name, wish, Maps(paths, loop, wish.size), render.fps / render.fps_base)
        note_export(request.out, wish.form, name, said)
        yield f"{name}: {len(loop.frames)} frames, {loop.by}; {said['files'][0]} in {out / folder_name(name)}"


class Maps:
    """The frames of a Loop as images of `size` texels, from the baked files {number: path}."""

    def __init__(self, paths, loop: Loop, size=0):
        self._paths, self.loop, self._size = paths, loop, size
        self._read = lru_cache(maxsize=2)(self._one)

    def __iter__(self):
        for parts in self.loop.frames:
            yield sum(np.float32(weight) * self._read(number) for number, weight in parts)

    def _one(self, number):
        image = read_map(self._paths[number])
        return reduced(image, self._size) if self._size else image

    def measure(self):
        """(largest value of each channel, its mean over the texels that are lit in any frame), (3,) both."""
        most, total, lit, count = np.zeros(3), 0.0, False, 0
        for image in self:
            most = np.maximum(most, image.max(axis=(0, 1)))
            total, lit, count = total + image.astype(np.float64), lit | (image.max(axis=2) > 0), count + 1
        mean = total[lit].mean(axis=0) / count if np.any(lit) else np.zeros(3)
        return most, mean


def _write(folder, name, wish, maps, rate):
    """Write the files of one receiver; returns what its JSON says."""
    most, mean = maps.measure()
    divisor = np.where(mean > 0, mean, 1.0) if wish.form == "cookie" else np.ones(3)
    scale = (float((most / divisor).max()) or 1.0) if wish.png else 1.0
    images = (image / divisor for image in maps)
    place = Path(folder) / folder_name(name)
    said = {
        "form": wish.form,
        "receiver": name,
        "format": "PNG, 16 bits" if wish.png else "OpenEXR, half floats",
        "colour_space": "linear",
        "value_scale": scale,  # what a value of 1 in the file stands for
        "unit": "times the mean" if wish.form == "cookie" else "W/m2",
        "mean": mean,  # W/m2, over the texels that are lit
        "frames": len(maps.loop.frames),
        "first_frame": maps.loop.frames[0][0][0] if wish.loop is None else 1,
        "frame_rate": rate,
        "loop": maps.loop.repeats,
        "loop_by": maps.loop.by,
    }
    forms = {"sequence": _sequence, "atlas": _atlas, "cookie": _sequence}
    said.update(forms[wish.form](place, images, said, lambda image: _encoded(image, wish.png, scale)))
    write_json(place / f"{wish.form}.json", said)
    return said


def _encoded(image, png, scale):
    """(bytes of a file, how its name ends) of an image."""
    # Sums and quotients of the largest value may come out a last bit above it.
    return (encode_png(np.minimum(image, scale), scale), ".png") if png else (encode(image), ".exr")


def _sequence(place, images, said, encoded):
    """Write a file for each frame, numbered on from the first."""
    stem, files = "caustics" if said["form"] == "sequence" else said["form"], []
    for number, image in enumerate(images, said["first_frame"]):
        content, ending = encoded(image)
        files.append(f"{stem}_{number:04d}{ending}")
        write_file(place / files[-1], content)
        size = image.shape[:2]
    for old in (*place.glob(f"{stem}_*.exr"), *place.glob(f"{stem}_*.png")):
        if old.name not in files:  # of an earlier export: it would be shown as a part of this one
            old.unlink()
    return {"files": files, "resolution": size}


def _atlas(place, images, said, encoded):
    """Write all frames in one file, from the top left, row by row; what is left over stays black."""
    columns = math.ceil(math.sqrt(said["frames"]))
    rows = math.ceil(said["frames"] / columns)
    sheet = None
    for index, image in enumerate(images):
        side = image.shape[0]
        if sheet is None:
            if columns * side > MOST_SIDE:
                raise DappleError(
                    f"An atlas of {columns} x {rows} frames of {side} texels is larger than {MOST_SIDE}; set a smaller "
                    f"size, {MOST_SIDE // columns} at most, or fewer frames."
                )
            sheet = np.zeros((rows * side, columns * side, 3), np.float32)
        row, column = divmod(index, columns)
        bottom = (rows - 1 - row) * side
        sheet[bottom : bottom + side, column * side : (column + 1) * side] = image
    content, ending = encoded(sheet)
    write_file(place / f"atlas{ending}", content)
    order = "from the top left, row by row"
    return {"files": [f"atlas{ending}"], "resolution": (side, side), "rows": rows, "columns": columns, "order": order}
