"""What the frames of one bake share, so that none of it is made twice."""

from __future__ import annotations

from ...kernels.unchanged import unchanged
from ..errors import DappleError


class TexelCache:
    """Texels of each receiver, made anew only where its mesh or UVs changed since the frame before."""

    def __init__(self, settings):
        self._settings = settings
        self._known = {}

    def of(self, receiver):
        """The Texels of a Receiver; raises DappleError for UVs that cannot carry a lightmap."""
        from ...kernels.maps.texels import UVError, rasterise

        before, texels = self._known.get(receiver.name, (None, None))
        if before is None or not unchanged(before, receiver):
            try:
                texels = rasterise(receiver, self._settings.resolution, self._settings.padding)
            except UVError as error:
                raise DappleError(f"Receiver '{receiver.name}' cannot take a lightmap: {error}.") from error
            self._known[receiver.name] = (receiver, texels)
        return texels
