# SPDX-License-Identifier: GPL-3.0-or-later
"""Integer keys to indices, for many keys at once: a hash table in numpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

EMPTY = np.iinfo(np.int64).min
# Knuth's multiplicative hashing, by the 64-bit golden ratio ("The Art of Computer Programming" 3, section 6.4).
GOLDEN = np.uint64(0x9E3779B97F4A7C15)


class KeyTable:
    """Finds the indices of ``keys`` (n,) int64, all different and >= 0. Open addressing with linear probing (Knuth,
    ibid.), a quarter full at most: 12 to 24 slots' bytes a key."""

    def __init__(self, keys: NDArray[np.int64]):
        bits = max(4, int(4 * len(keys)).bit_length())
        self._shift, self._mask = np.uint64(64 - bits), 2**bits - 1
        self._keys = np.full(2**bits, EMPTY)
        self._index = np.empty(2**bits, np.int32)
        slot, left = self._slot(keys), np.arange(len(keys), dtype=np.int32)
        while len(left):
            # Of those that want the same free slot one gets it, the last; the others go on with those that met a
            # taken one.
            free = self._keys[slot] == EMPTY
            self._keys[slot[free]] = keys[left[free]]
            placed = free & (self._keys[slot] == keys[left])
            self._index[slot[placed]] = left[placed]
            left, slot = left[~placed], (slot[~placed] + 1) & self._mask

    def _slot(self, keys: NDArray[np.int64]) -> NDArray[np.int64]:
        return ((keys.view(np.uint64) * GOLDEN) >> self._shift).view(np.int64)

    def find(self, keys: NDArray[np.int64]) -> NDArray[np.int32]:
        """Index (k,) of each of ``keys`` (k,), -1 for those that the table lacks."""
        slot = self._slot(keys)
        there = self._keys.take(slot)
        result = np.where(there == keys, self._index.take(slot), np.int32(-1))
        left = np.flatnonzero((there != keys) & (there != EMPTY))
        slot = slot[left]
        while len(left):
            slot = (slot + 1) & self._mask
            there, wanted = self._keys.take(slot), keys[left]
            found = there == wanted
            result[left[found]] = self._index.take(slot[found])
            on = ~found & (there != EMPTY)
            left, slot = left[on], slot[on]
        return result
