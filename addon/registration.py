"""One ordered list of classes, the scene's settings and the command-line command."""

from __future__ import annotations

import bpy

from ..operators.buttons.ops_attach import DAPPLE_OT_attach, DAPPLE_OT_detach, DAPPLE_OT_look_through
from ..operators.buttons.ops_bake import DAPPLE_OT_bake_animation, DAPPLE_OT_bake_frame, DAPPLE_OT_stop
from ..operators.buttons.ops_choose import DAPPLE_OT_choose
from ..operators.buttons.ops_export import DAPPLE_OT_export
from ..operators.buttons.ops_live import DAPPLE_OT_live_preview
from ..operators.buttons.ops_overlay import DAPPLE_OT_show_status
from ..operators.buttons.ops_uvs import DAPPLE_OT_lightmap_uvs
from ..operators.chart.ops_chart import DAPPLE_OT_chart
from ..operators.show import live
from . import panel_status, panels
from .properties import DappleObject, DappleProgress, DappleSettings

# A class that another one names comes before it: settings before the pointers to them, parent panels before children.
CLASSES = (
    DappleSettings,
    DappleObject,
    DappleProgress,
    DAPPLE_OT_bake_frame,
    DAPPLE_OT_bake_animation,
    DAPPLE_OT_stop,
    DAPPLE_OT_attach,
    DAPPLE_OT_detach,
    DAPPLE_OT_look_through,
    DAPPLE_OT_choose,
    DAPPLE_OT_lightmap_uvs,
    DAPPLE_OT_live_preview,
    DAPPLE_OT_show_status,
    DAPPLE_OT_export,
    DAPPLE_OT_chart,
    panels.DAPPLE_PT_bake,
    panels.DAPPLE_PT_scene,
    panels.DAPPLE_PT_casters,
    panels.DAPPLE_PT_influence,
    panels.DAPPLE_PT_quality,
    panels.DAPPLE_PT_output,
    panels.DAPPLE_PT_margin,
    panel_status.DAPPLE_PT_status,
)

_register_classes, _unregister_classes = bpy.utils.register_classes_factory(CLASSES)
_commands: list[object] = []


def _command(argv: list[str]) -> int:
    """Run `blender -b SCENE.blend --command dapple ...` and return its exit code."""
    # Only a pipeline needs the command line: an artist's Blender starts without it.
    from ..operators import cli

    return cli.main(argv)


def register() -> None:
    """Add the classes, `Scene.dapple`, `Object.dapple`, `WindowManager.dapple` and the command `dapple` to Blender."""
    _register_classes()
    bpy.types.Scene.dapple = bpy.props.PointerProperty(type=DappleSettings)
    bpy.types.Object.dapple = bpy.props.PointerProperty(type=DappleObject)
    bpy.types.WindowManager.dapple = bpy.props.PointerProperty(type=DappleProgress)
    _commands.append(bpy.utils.register_cli_command("dapple", _command))


def unregister() -> None:
    """Take away what `register` added, last first."""
    live.stop(bpy.context)
    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
    del bpy.types.WindowManager.dapple, bpy.types.Object.dapple, bpy.types.Scene.dapple
    _unregister_classes()
