"""Live preview: while it is on, each frame that is come to is baked at Draft and shown, in memory, on the receivers.

No map is written and none is read. Receivers that show their maps show the preview in their place; the others are lit
for as long as it lasts. All of it goes before the file is saved or rendered, and comes back after a save.
"""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ..bake.bake import request_from_scene
from ..buttons.presets import PRESETS
from ..errors import DappleError
from ..read.casters import caster_names
from ..read.lightmap_uvs import supply
from . import attach

RESOLUTION = 256
LIVE = "dapple_live"  # on an image: whose preview it is; on an object: it is lit by the preview only
_running: list[_Live] = []


class _Live:
    """The preview of one scene."""

    def __init__(self, context, request):
        from ..bake.solve_now import Now

        self.scene, self.request, self.trouble = context.scene.name, request, ""
        self._now = Now(request)
        self._casters = caster_names(context.evaluated_depsgraph_get(), {*request.water, *request.receivers})

    def show(self, context):
        """Bake the current frame and show it; raises DappleError, and shows what it showed."""
        scene, solution = self._now.solve(context)
        names = [receiver.name for receiver in scene.receivers]
        images = {name: _paint(name, pixels) for name, pixels in zip(names, solution.images, strict=True)}
        new = attach.show_images(context, self.request.receivers, images, (*self.request.water, *self._casters))
        for obj in new:
            obj[LIVE] = True


def is_on() -> bool:
    """Whether a preview is shown."""
    return bool(_running)


def trouble() -> str:
    """Why the current frame shows no preview; empty if it does."""
    return _running[0].trouble if _running else ""


def start(context) -> str:
    """Show the current frame, and each that is come to; returns a sentence on UV maps that it had to make, if any.

    Raises DappleError where there is nothing that it can show.
    """
    stop(context)
    frame = (context.scene.frame_current,)
    request = request_from_scene(context.scene, frames=frame, out="unused")
    made = supply(context, request)
    settings = replace(request.settings, resolution=RESOLUTION, tolerance=PRESETS["DRAFT"], reuse=0.0)
    live = _Live(context, replace(request, settings=settings, density=0.0))
    live.show(context)
    _running.append(live)
    for handlers, handler in _HANDLERS:
        handlers.append(handler)
    return made


def stop(context) -> None:
    """Show the maps on disk again on what showed them before, and take the preview off all else."""
    if not _running:
        return
    _forget()
    _hide(context)


def _forget(*_):
    _running.clear()
    for handlers, handler in _HANDLERS:
        if handler in handlers:
            handlers.remove(handler)


def _hide(context):
    """Take every preview out of the file."""
    attach.show_maps()  # before detaching, which drops images that nothing shows
    lit = [obj.name for obj in bpy.data.objects if LIVE in obj]
    for name in lit:
        del bpy.data.objects[name][LIVE]
    attach.detach(context, lit)
    for image in [image for image in bpy.data.images if LIVE in image]:
        bpy.data.images.remove(image)


def _paint(name, pixels):
    """The preview image of a map, with pixels (H,W,3)."""
    height, width = pixels.shape[:2]
    image = next((image for image in bpy.data.images if image.get(LIVE) == name), None)
    if image is None:
        image = bpy.data.images.new(f"Dapple Live {name}", width, height, alpha=False, float_buffer=True)
        image[LIVE] = name
        image.colorspace_settings.name = "Non-Color"
    opaque = np.ones((height, width, 4), np.float32)
    opaque[..., :3] = pixels
    image.pixels.foreach_set(opaque.ravel())
    image.update()
    return image


def _tick():
    """Show the frame that the scene is at now, however many it passed on the way."""
    if _running and not bpy.app.is_job_running("RENDER"):
        live = _running[0]
        try:
            if bpy.context.scene.name == live.scene:
                live.show(bpy.context)
            live.trouble = ""
        except DappleError as error:
            live.trouble = str(error)


def _frame_changed(*_):
    # Once, when Blender has nothing else to do: frames that are only passed while scrubbing are not baked.
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick)


def _before_save(*_):
    _hide(bpy.context)


def _after_save(*_):
    _frame_changed()


def _before_render(*_):
    stop(bpy.context)


_HANDLERS = (
    (bpy.app.handlers.frame_change_post, _frame_changed),
    (bpy.app.handlers.save_pre, _before_save),
    (bpy.app.handlers.save_post, _after_save),
    (bpy.app.handlers.render_init, _before_render),
    (bpy.app.handlers.load_pre, _forget),
)
