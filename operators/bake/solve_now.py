"""Solve the current frame in memory, for what is shown and not kept."""

from __future__ import annotations

from ...kernels.sequence import Sequence
from ..errors import DappleError
from ..read.density import Sizes
from ..read.extract import read_scene
from ..read.mesh_arrays import TopologyCache
from .shared import TexelCache


class Now:
    """Solves whatever frame the scene is at, by one request; keeps what frames share. The first is their anchor."""

    def __init__(self, request):
        self._request, self._sequence = request, None
        self._topology, self._texels = TopologyCache(), TexelCache(request.settings.padding)
        self._sizes = Sizes(request.settings.resolution, request.density)

    def solve(self, context):
        """(Scene, Solution) of the current frame; raises DappleError for what cannot be baked."""
        from ...kernels import methods

        request, depsgraph = self._request, context.evaluated_depsgraph_get()
        scene, _ = read_scene(depsgraph, request.water, request.receivers, self._topology, request.volume)
        if self._sequence is None:
            self._sizes.keep(scene)
        charts = tuple(map(self._texels.of, scene.receivers, self._sizes.of(scene)))
        try:
            if self._sequence is None:
                anchor = methods.prepare(scene, charts, request.settings)
                self._sequence = Sequence(methods.solve, request.settings, anchor)
            return scene, self._sequence.solve(context.scene.frame_current, scene, charts)
        except ValueError as error:  # the kernels' own sentence
            raise DappleError(str(error)) from error
