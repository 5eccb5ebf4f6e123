"""What a surface changes of where a ray is, looked up: rays are in few sets of bodies, and meet few materials.

`Media` tells it of one ray by its mask. Here masks have numbers, states, in the order in which rays come to have them,
and what a meeting makes of a state, a material and a side is worked out once and kept in tables.
"""

from __future__ import annotations

import numpy as np

CHOICE, STRAIGHT, MIRROR = 0, 1, 2


class Crossings:
    """unit (materials,): what a mask of `media.Media` grows by in bodies of these materials, 0 for mirrors.

    masks (states,): of each state, the first that of air. Of keys from `key`: turned and passed (n,), the states of
    what stays on the side that it came from, and of what goes through; before (n,), the medium on the way there; kind
    (n,), CHOICE where light parts, STRAIGHT where both media are one, MIRROR; ratio (n,) of the indices before and
    behind; wrong (n,) bool, see `media.Media.crossed`.
    """

    def __init__(self, media, unit):
        self._media, self._unit, self._number = media, np.asarray(unit), {}
        self.masks, self.medium = np.zeros((2, 0), np.int64)
        self.turned, self.passed, self.before = np.zeros((3, 0), np.int64)
        self.kind, self.ratio, self.wrong = np.zeros(0, np.int8), np.zeros(0), np.zeros(0, bool)
        self.state(0)

    def state(self, mask):
        """The number of a mask."""
        if mask not in self._number:
            self._number[mask] = len(self._number)
            self.masks = np.append(self.masks, mask)
            self.medium = np.append(self.medium, self._media.filling(np.array([mask])))
            unknown = np.full(2 * len(self._unit), -1)
            for name in ("turned", "passed", "before", "kind", "ratio", "wrong"):
                table = getattr(self, name)
                setattr(self, name, np.append(table, unknown.astype(table.dtype)))
        return self._number[mask]

    def key(self, state, twice, enters):
        """Rows (k,) of the tables for rays in states (k,) that meet materials, twice their numbers (k,), from outside
        where they enter (k,) bool."""
        key = state * (2 * len(self._unit))
        key += twice
        key += enters
        if (np.take(self.turned, key) < 0).any():
            for new in np.unique(key):
                if self.turned[new] < 0:
                    self._work_out(int(new))
        return key

    def _work_out(self, key):
        """Fill a row of the tables."""
        state, rest = divmod(key, 2 * len(self._unit))
        unit, enters = self._unit[[rest // 2]], np.array([rest % 2 == 1])
        before, behind, wrong = self._media.crossed(self.masks[[state]], unit, enters)
        turned, passed = self.state(int(before[0])), self.state(int(behind[0]))
        own, other = self.medium[turned], self.medium[passed]
        self.turned[key], self.passed[key], self.before[key], self.wrong[key] = turned, passed, own, wrong[0]
        self.kind[key] = MIRROR if unit[0] == 0 else STRAIGHT if own == other else CHOICE
        self.ratio[key] = self._media.eta[own] / self._media.eta[other]
