"""Codes that are asked for: a tree of their prefixes, along which rays go as far as one of their codes does."""

from __future__ import annotations

import numpy as np

MOST = 62  # codes at once: a photon's are the bits of an integer


class Codes:
    """words: at most MOST codes, see `follow`; code k is bit k of what a photon asks for.

    Nodes are the prefixes of the codes, the first that of no choice. step (2, nodes): where turning back and passing
    lead; below (nodes,): the bits of codes that a prefix may become; own (nodes,): the bit of the one that it is. The
    last node is that of all other codes.
    """

    def __init__(self, words):
        self.words = [int(word) for word in words]
        if len(self.words) > MOST:
            raise ValueError(f"words must be at most {MOST}, got {len(self.words)}")
        prefixes = sorted({1, *(word >> k for word in self.words for k in range(word.bit_length()))})
        index = {prefix: k for k, prefix in enumerate(prefixes)}
        away = len(prefixes)
        self.step = np.array([[index.get(2 * p + turn, away) for p in prefixes] + [away] for turn in (0, 1)])
        self.below, self.own = np.zeros((2, away + 1), np.int64)
        self.number = np.full(away + 1, -1)
        for k, word in enumerate(self.words):
            self.own[index[word]], self.number[index[word]] = 1 << k, k
            for length in range(word.bit_length()):
                self.below[index[word >> length]] |= 1 << k

    def every(self):
        """What a photon asks for that asks for all of them."""
        return (1 << len(self.words)) - 1

    def leads(self, turn, node, want):
        """Whether (k,) turning back (0) or passing (1) at nodes (k,) leads to one of the codes want (k,)."""
        return (np.take(self.below, np.take(self.step[turn], node)) & want) != 0
