"""Where points of the entry send their light, and what of it comes there: a row for each way that ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass
class Ways:
    """photon (k,): which point each is of; code (k,): its number among `Codes`, else the word itself; chart (k,) that
    it ends on, or why on none, see `cast.Cast.ways`; x, y (k,) texel coordinates and way (k,) [m] all the way, 0 where
    there is no chart; share (k,), colour (C,k) and path (k,), see `follow.Rays`, colour as it arrives."""

    photon: np.ndarray
    code: np.ndarray
    chart: np.ndarray
    x: np.ndarray
    y: np.ndarray
    way: np.ndarray
    share: np.ndarray
    colour: np.ndarray
    path: np.ndarray

    @classmethod
    def none(cls, channels):
        zero, number = np.zeros(0), np.zeros(0, np.int64)
        return cls(number, number, number, zero, zero, zero, zero, np.zeros((channels, 0)), number)

    def take(self, index):
        return Ways(*(np.take(a, index, axis=-1) for a in vars(self).values()))

    def later(self, count):
        """The same of photons that come after so many others."""
        return replace(self, photon=self.photon + count)

    @classmethod
    def join(cls, parts):
        """One of a list of Ways that is not empty."""
        if len(parts) == 1:
            return parts[0]
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*(np.concatenate(column, axis=-1) for column in columns))

    def ordered(self):
        """The same by photons, and by codes within these: sums over them do not depend on how they were come by."""
        order = np.argsort(self.code.astype(np.int16), kind="stable")  # few bits sort in no time
        for shift in (0, 16):
            part = (self.photon >> shift & 0xFFFF).astype(np.uint16)
            if part.any():
                order = order[np.argsort(part[order], kind="stable")]
        return self.take(order)
