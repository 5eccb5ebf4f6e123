"""Solve the current frame in memory, for what is shown and not kept."""

from __future__ import annotations

from .extract import read_scene
from .shared import Shared


class Now:
    """Solves whatever frame the scene is at, by one request; keeps what frames share."""

    def __init__(self, request):
        self._request, self._shared = request, Shared(request.settings)

    def solve(self, context):
        """(Scene, Solution) of the current frame; raises DappleError for what cannot be baked."""
        request, shared = self._request, self._shared
        depsgraph = context.evaluated_depsgraph_get()
        scene, _ = read_scene(depsgraph, request.water, request.receivers, shared.topology, request.volume)
        charts = tuple(shared.texels.of(receiver) for receiver in scene.receivers)
        return scene, shared.sequence.solve(context.scene.frame_current, scene, charts)
