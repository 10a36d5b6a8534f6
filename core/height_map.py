# SPDX-License-Identifier: GPL-3.0-or-later
"""A height map as a surface that tiles: what the published bounce curves were simulated on.

Pixels are squares of side 1 / w, so that the map is 1 wide; column j lies at x = (j + 0.5) / w, row i at
y = (i + 0.5) / w. The surface joins the pixels' centres. It repeats in x and y: rays meet 3 x 3 tiles, and start in the
middle one (Patapom, "Improved Ambient Occlusion", Collecting Data).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .rays import Occluders
from .sample_points import SurfacePoints

# Each takes 18 triangles.
MOST_PIXELS = 2**19


class HeightMap:
    """Heights of h x w pixels on a map of width 1.

    heights    (h, w) in any unit; the lowest becomes 0, the highest ``amplitude``. All alike: a plane
    amplitude  relief as a fraction of the map's width, at least 0; the notes advise 0.1

    As attributes, ``heights`` (h, w) float64 are in widths of the map, ``extent`` is its longer side.

    Raises ValueError for heights that are not 2-D, finite, at least 2 x 2 and at most MOST_PIXELS pixels, and for an
    amplitude that is negative or not finite.
    """

    def __init__(self, heights: ArrayLike, amplitude: float):
        heights = np.asarray(heights, np.float64)
        if heights.ndim != 2 or min(heights.shape) < 2:
            raise ValueError(f"a height map needs 2 x 2 pixels or more of one channel, not shape {heights.shape}")
        if heights.size > MOST_PIXELS:
            height, width = heights.shape
            raise ValueError(f"a height map of {width} x {height} pixels passes {MOST_PIXELS} in all: scale it down")
        if not np.isfinite(heights).all():
            raise ValueError("heights must be finite: the map holds infinity or NaN")
        if not (np.isfinite(amplitude) and amplitude >= 0.0):
            raise ValueError(f"the amplitude must be 0 or more, as a fraction of the map's width, not {amplitude}")
        # Halved first: the range of float64 is wider than float64.
        low, high = 0.5 * heights.min(), 0.5 * heights.max()
        relief = (0.5 * heights - low) / (high - low) if high > low else np.zeros(heights.shape)
        self.heights = amplitude * relief
        self.extent = max(1.0, heights.shape[0] / heights.shape[1])

    def __len__(self) -> int:
        """Number of pixels."""
        return self.heights.size

    def occluders(self) -> Occluders:
        """The 3 x 3 tiles; the middle one begins at x = y = 0."""
        height, width = self.heights.shape
        tiled = np.pad(self.heights, ((height, height + 1), (width, width + 1)), mode="wrap")
        row, column = np.indices(tiled.shape)
        vertices = np.stack(
            ((column - width + 0.5) / width, (row - height + 0.5) / width, tiled), axis=-1, dtype=np.float64
        )
        index = np.arange(tiled.size, dtype=np.int32).reshape(tiled.shape)
        a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
        triangles = np.stack((np.stack((a, b, c), axis=-1), np.stack((a, c, d), axis=-1)), axis=2)
        return Occluders(vertices.reshape(-1, 3), triangles.reshape(-1, 3), centre=(0.5, 0.5 * height / width, 0.0))

    def points(self) -> SurfacePoints:
        """The pixels of the middle tile, row by row. Normals by central differences across its edges."""
        width = self.heights.shape[1]
        row, column = np.indices(self.heights.shape)
        positions = np.stack(((column + 0.5) / width, (row + 0.5) / width, self.heights), axis=-1)
        slopes = [(np.roll(self.heights, -1, axis) - np.roll(self.heights, 1, axis)) * (0.5 * width) for axis in (1, 0)]
        normals = np.stack((-slopes[0], -slopes[1], np.ones_like(self.heights)), axis=-1)
        normals /= np.sqrt(np.square(normals).sum(axis=-1, keepdims=True))
        return SurfacePoints(positions.reshape(-1, 3), normals.reshape(-1, 3))

    def pixels_at(self, positions: NDArray) -> NDArray[np.intp]:
        """The pixel (k,), numbered as in :meth:`points`, that holds each of ``positions`` (k, 3) on any tile."""
        height, width = self.heights.shape
        column, row = (np.floor(positions[:, axis] * width).astype(np.intp) for axis in (0, 1))
        return row % height * width + column % width
