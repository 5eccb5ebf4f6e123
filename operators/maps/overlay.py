"""False colours for what became of each texel: an image per receiver."""

from __future__ import annotations

import bpy
import numpy as np

from ...kernels.status import Status

OVERLAY = "dapple_status"  # marks our images, and says whose they are
# Linear RGB of each status; what is fine is grey, what is not has a colour of its own.
COLOURS = {
    Status.EMPTY: (0.0, 0.0, 0.0),
    Status.LIT: (0.5, 0.5, 0.5),
    Status.DARK: (0.1, 0.1, 0.1),
    Status.NO_WATER: (0.0, 0.1, 0.6),
    Status.OFF_THE_RIM: (0.0, 0.5, 0.8),
    Status.NO_ROOT: (0.5, 0.0, 0.6),
    Status.BLOCKED: (0.5, 0.25, 0.05),
    Status.TORN: (0.9, 0.7, 0.0),
    Status.LOST: (0.9, 0.0, 0.0),
    Status.INCOMPLETE: (1.0, 0.2, 0.5),
}
NAMES = {
    Status.NO_WATER: "dark blue",
    Status.OFF_THE_RIM: "light blue",
    Status.NO_ROOT: "purple",
    Status.BLOCKED: "brown",
    Status.TORN: "yellow",
    Status.LOST: "red",
    Status.INCOMPLETE: "pink",
}


def colour_name(status: str) -> str:
    """The word for the colour of a status, as bake.json calls it; empty for one that is fine or unknown."""
    return next((word for known, word in NAMES.items() if known.name.lower() == status), "")


def show(scene, solution) -> list[bpy.types.Image]:
    """Make or renew the image of each receiver of a Scene from the status codes of its Solution."""
    table = np.ones((len(Status), 4), np.float32)
    for status, colour in COLOURS.items():
        table[status, :3] = colour
    pairs = zip(scene.receivers, solution.status, strict=True)
    return [_paint(receiver.name, table[codes]) for receiver, codes in pairs]


def _paint(name, pixels):
    """The overlay of a receiver with these pixels (H,W,4), linear."""
    height, width = pixels.shape[:2]
    image = next((image for image in bpy.data.images if image.get(OVERLAY) == name), None)
    if image is None:
        image = bpy.data.images.new(f"Dapple Status {name}", width, height, float_buffer=True)
        image[OVERLAY] = name
        image.colorspace_settings.name = "Non-Color"
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image
