# SPDX-License-Identifier: GPL-3.0-or-later
"""Points along a space-filling curve, so that rays traced together meet the same part of the tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def morton_order(points: NDArray) -> NDArray[np.intp]:
    """Indices (n,) that sort ``points`` (n, 3) along a Morton (Z-order) curve of 2^21 steps a side.

    Morton 1966; bits spread by the usual magic numbers. Ties keep their order, so the result is reproducible.
    """
    if len(points) == 0:
        return np.empty(0, np.intp)
    low = points.min(axis=0)
    extent = max(float((points.max(axis=0) - low).max()), 1e-300)
    cells = np.minimum((points - low) * (2.0**21 / extent), 2.0**21 - 1).astype(np.uint64)
    code = _spread(cells[:, 0]) | _spread(cells[:, 1]) << np.uint64(1) | _spread(cells[:, 2]) << np.uint64(2)
    return np.argsort(code, kind="stable")


def _spread(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Insert two zero bits between the 21 bits of each x."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | x << np.uint64(shift)) & np.uint64(mask)
    return x
