"""What all lights of one frame share: things in the way, and how the water's triangles lie and meet."""

from __future__ import annotations

from functools import cached_property

from ..facets import Facets
from ..lit_water import light_water
from ..rays import solid
from .edges import Edges
from .meetings import Meetings
from .plane import one_plane
from .silhouettes import Silhouettes


class Surroundings:
    """The surroundings of a Scene's light on Texels, of which each part is made when it is first asked for; casters
    stand in the way of light that meets only water."""

    def __init__(self, scene, texels, settings):
        self.scene, self.texels, self.settings = scene, texels, settings
        *self.solids, self.tracer = solid((*scene.receivers, *scene.occluders, *scene.casters))
        self._meetings = {}

    @cached_property
    def outlines(self):
        """Silhouettes of all that stands in the way."""
        return Silhouettes(*self.solids)

    @cached_property
    def edges(self):
        """Edges of the water."""
        water = self.scene.water
        return Edges.of(water.triangles, water.twins, water.triangles is water.normal_triangles)

    @cached_property
    def plane(self):
        """The scene's only plane, see `plane.one_plane`."""
        return one_plane(self.scene, self.texels)

    def lit(self, light):
        """The LitWater of a light."""
        return light_water(self.scene.water, light, self._facets)

    def meetings(self, lit):
        """The Meetings of a LitWater: the same for all lights that see the water from the same side."""
        turned = lit.facets is not self._facets
        if turned not in self._meetings:
            self._meetings[turned] = Meetings.of(lit, self.scene.water.twins, self.tracer, self.scene.eta)
        return self._meetings[turned]

    @cached_property
    def _facets(self):
        water = self.scene.water
        return Facets.of(water.positions, water.normals, water.triangles, water.normal_triangles)
