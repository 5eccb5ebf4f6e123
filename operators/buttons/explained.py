"""Buttons that say, while they are greyed, what they still lack."""

from __future__ import annotations

from ..read.receivers import can_receive
from .choose import can_choose, flagged_receivers, wants_choice


class Explained:
    """A button that is greyed for a reason; a subclass says which."""

    @classmethod
    def lacks(cls, context) -> str:
        """Say what the button lacks, as a sentence for its tooltip; empty if nothing."""
        return receivers_lacking(context.scene)

    @classmethod
    def poll(cls, context):
        reason = cls.lacks(context)
        if reason:
            cls.poll_message_set(reason)
        return not reason


def receivers_lacking(scene) -> str:
    """Say why nothing in `scene` takes light; empty if something does."""
    settings = scene.dapple
    if settings.receivers is None:
        return "" if flagged_receivers(scene) else "Pick the collection of receivers first"
    if not any(can_receive(o) and o != settings.water for o in settings.receivers.all_objects):
        return "The collection of receivers holds no mesh but the water"
    return ""


def choice_lacking(context) -> str:
    """As `receivers_lacking`, for a button that can take water and receivers from the selection."""
    if not wants_choice(context.scene):
        return receivers_lacking(context.scene)
    return "" if can_choose(context) else "Select the water and the meshes that its light falls on, or pick them below"


def workers_busy(window_manager) -> str:
    """Say what keeps the workers busy; empty if nothing."""
    running = {operator.bl_idname for window in window_manager.windows for operator in window.modal_operators}
    if "DAPPLE_OT_chart" in running:
        return "Methods are being measured: press Esc to stop that"
    if running & {"DAPPLE_OT_bake_frame", "DAPPLE_OT_bake_animation"}:
        return "A bake is running: press Esc to stop it"
    return ""
