# SPDX-License-Identifier: GPL-3.0-or-later
"""Images made smaller, each new pixel the mean over its area."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def fitting_shape(shape: tuple[int, int], most: int) -> tuple[int, int]:
    """The largest (h, w), at least 2 x 2, of about the same proportions as ``shape`` with no more than ``most`` pixels;
    ``shape`` itself where it has no more."""
    height, width = shape
    if height * width <= most:
        return shape
    scale = math.sqrt(most / (height * width))
    short = max(2, int(scale * min(shape)))
    long = min(max(2, int(scale * max(shape))), most // short)
    return (short, long) if height <= width else (long, short)


def area_mean(pixels: NDArray, shape: tuple[int, int]) -> NDArray[np.float64]:
    """``pixels`` (h, w) as ``shape``, of which each side is at most as long: the exact mean over each new pixel.

    What tiles goes on to tile. Memory: the old side times the new one, 8 bytes each, for either side.
    """
    rows, columns = (_shares(old, new) for old, new in zip(pixels.shape, shape, strict=True))
    return rows @ pixels @ columns.T


def _shares(old: int, new: int) -> NDArray[np.float64]:
    """(new, old): the share of each old pixel in each new one, along a line that both divide evenly."""
    edges = np.arange(new + 1)[:, None] * (old / new)
    # How much of each old pixel lies before each edge.
    before = np.clip(edges - np.arange(old), 0.0, 1.0)
    return np.diff(before, axis=0) * (new / old)
