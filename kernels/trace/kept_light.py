"""What lights brought over casters, kept from frame to frame: where nothing that bends it differs no ray is cast again.

Light is followed over its power, and coloured after. So a lamp that changes its strength or colour, or stands still
while another one moves, brings what it brought. Where a thing moves, single ways are kept, see `known.py`.
"""

from __future__ import annotations

from dataclasses import replace

from ..scene import Sun
from ..unchanged import unchanged
from .known import Known

_MOST = 1 << 26  # bytes of flux that are kept: what was not asked for the longest goes
_MOST_WAYS = 1 << 28  # bytes of ways that are kept, about


class Followed:
    """A light whose `follow()` gives what it brings over its power: flux (C,K) to the texels, what is lost and what
    came in, and the predicted relative mean squared error and the Strays; `in_colour` gives the first three in watts.
    """

    def keep(self, follow):
        """What follow() returns, now or in a frame before; nothing is kept unless another `keep` is set."""
        return follow()

    def spread(self):
        """As `throw`, without noise that shows, and the predicted relative mean squared error."""
        flux, lost, met, error, self.strays = self.keep(self.follow)
        return *self.in_colour(flux, lost, met), error


class KeptLight:
    """Keeps what each light brought last, in each channel group and to each tolerance that frames are solved for."""

    def __init__(self):
        self._known, self._ways = {}, {}

    def known(self, light, number, lit, part):
        """The Known of a light, of this number of those that stand for its size, and of a Part of it; lit as in
        `of`."""
        key = light.name, number, lit.tobytes(), part.mine.tobytes(), part.rest
        for old in list(self._ways)[: list(self._ways).index(key)] if key in self._ways else ():
            del self._ways[old]  # it was not asked for since this one was
        own = self._ways.pop(key, None) or Known()
        own.most = _MOST_WAYS - sum(other.size() for other in self._ways.values())
        self._ways[key] = own
        return own

    def of(self, scene, light, lit, texels, settings, follow):
        """What follow() returns, for a light of a Scene on Texels, called only if anything but the power of lights
        differs from when it was called last; lit (3,) bool: channels in which there is any light."""
        key = light.name, lit.tobytes(), settings
        inputs = replace(scene, lights=()), without_power(light), tuple(texels)
        before, brought = self._known.pop(key, (None, None))
        if before is None or not unchanged(before, inputs):
            brought = follow()
        self._known[key] = inputs, brought
        while sum(flux.nbytes for _, (flux, *_) in self._known.values()) > _MOST:
            del self._known[next(iter(self._known))]
        return brought


def without_power(light):
    """A light whose power is 0."""
    return replace(light, **{"irradiance" if isinstance(light, Sun) else "intensity": (0.0, 0.0, 0.0)})
