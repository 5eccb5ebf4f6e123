"""What the last bake was: method and why, the energy's balance, texels that want a look; and exports of it."""

from __future__ import annotations

import bpy

from ..operators.bake.bake import output_folder
from ..operators.bake.last_bake import last_bake
from ..operators.errors import DappleError
from ..operators.maps.overlay import colour_name
from .choices import METHODS
from .panels import Sidebar, wrapped


class DAPPLE_PT_status(Sidebar, bpy.types.Panel):
    """What bake.json says of the current frame, or of the one baked next to it."""

    bl_label = "Last Bake"

    def draw(self, context):
        layout = self.layout
        try:
            bake = last_bake(output_folder(context.scene.dapple.output), context.scene.frame_current)
        except DappleError as error:
            wrapped(layout, context, str(error))
        else:
            _draw_bake(layout, context, bake)
        buttons = layout.column(align=True)
        buttons.operator("dapple.show_status", icon="IMAGE_DATA")
        buttons.operator("dapple.export", icon="EXPORT")


def _draw_bake(layout, context, bake):
    """A LastBake, or that there is none."""
    if bake is None:
        return wrapped(layout, context, "Nothing is baked yet in the output folder")
    names = {identifier: name for identifier, name, _ in METHODS}
    method = names.get(bake.method, bake.method)
    wrapped(layout, context, f"Frame {bake.frame}: {method}, {bake.seconds:.2f} s")
    wrapped(layout, context, f"{bake.reason[:1].upper()}{bake.reason[1:]}")
    _energy(layout.column(align=True), bake)
    _texels(layout.column(align=True), bake)


def _energy(column, bake):
    """The balance of the light, a line for each place where it went."""
    _row(column, "On what bends light", f"{bake.watts:.4g} W")
    _row(column, "Received", f"{bake.received:.1%}")
    for cause, share in sorted(bake.lost.items(), key=lambda item: -item[1]):
        _row(column, "Lost: " + cause.replace("_", " "), f"{share:.1%}")
    if bake.error is not None:
        _row(column, "Estimated error", f"{bake.error:.1e}")


def _texels(column, bake):
    """Texels of a status other than fine, with the colour that they have in the overlay."""
    if not bake.odd:
        column.label(text="All texels are fine", icon="CHECKMARK")
    for status, count in bake.odd.items():
        colour = colour_name(status)
        name = status.replace("_", " ").capitalize()
        _row(column, f"{name} ({colour})" if colour else name, f"{count} texels")


def _row(column, name, value):
    split = column.split(factor=0.6)
    split.label(text=name)
    split.label(text=value, translate=False)
