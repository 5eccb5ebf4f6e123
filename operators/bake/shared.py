"""What the frames of one bake share, so that none of it is made twice."""

from __future__ import annotations

from ...kernels.unchanged import unchanged
from ..errors import DappleError


class TexelCache:
    """Texels of each receiver, made anew only where its mesh or UVs changed since the frame before."""

    def __init__(self, padding):
        self._padding, self._known = padding, {}

    def of(self, receiver, size):
        """The Texels of a Receiver, of `size` a side; raises DappleError for UVs that cannot carry a lightmap."""
        from ...kernels.maps.texels import UVError, rasterise

        before, texels = self._known.get(receiver.name, (None, None))
        if before is None or texels.resolution != size or not unchanged(before, receiver):
            try:
                texels = rasterise(receiver, size, self._padding)
            except UVError as error:
                raise DappleError(f"Receiver '{receiver.name}' cannot take a lightmap: {error}.") from error
            self._known[receiver.name] = (receiver, texels)
        return texels
