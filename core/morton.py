# SPDX-License-Identifier: GPL-3.0-or-later
"""Points along a space-filling curve, so that rays traced together meet the same part of the tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BITS = 10  # a side: the curve passes through 2^30 cells, and points in one cell keep their order


def morton_order(points: NDArray) -> NDArray[np.intp]:
    """Indices (n,) that sort ``points`` (n, 3), n < 2^32, along a Morton (Z-order) curve (Morton 1966)."""
    if len(points) == 0:
        return np.empty(0, np.intp)
    axes = np.ascontiguousarray(points.T, np.float64)
    low = axes.min(axis=1)
    scale = (2**BITS - 1) / max(float((axes.max(axis=1) - low).max()), 1e-300)
    spread = _spread_bits()
    code = np.zeros(len(points), np.uint64)
    for axis in range(3):
        code |= spread.take(((axes[axis] - low[axis]) * scale).astype(np.intp)) << np.uint64(axis)
    # The index in the low bits makes every key its own: sorting values is faster than sorting indices by them.
    key = code << np.uint64(32) | np.arange(len(points), dtype=np.uint64)
    key.sort()
    return (key & np.uint64(2**32 - 1)).astype(np.intp)


def _spread_bits() -> NDArray[np.uint64]:
    """(2^BITS,): every number with two zero bits after each of its own."""
    number = np.arange(2**BITS, dtype=np.uint64)
    return sum(((number >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit) for bit in range(BITS))
